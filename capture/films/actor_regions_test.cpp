#include "capture/films/actor_regions.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "capture/pictures/cv_image.h"

namespace keypose::capture::actor_regions_test {

TEST(ChooseActor, KeepsPiecesNearTheActorAndLeavesOthersOut) {
  Image8 regions(100, 60, 1), zone(100, 60, 1);
  cv::rectangle(MatOf(regions), cv::Rect(10, 10, 20, 30), cv::Scalar(255), -1);
  cv::rectangle(MatOf(regions), cv::Rect(10, 41, 20, 7), cv::Scalar(255), -1);
  cv::rectangle(MatOf(regions), cv::Rect(60, 5, 35, 50), cv::Scalar(255), -1);
  cv::rectangle(MatOf(zone), cv::Rect(5, 5, 30, 30), cv::Scalar(255), -1);
  const ActorRegions actor = ChooseActor(regions, zone);
  EXPECT_EQ(*actor.mask.at(20, 20), 255);
  EXPECT_EQ(*actor.mask.at(20, 45), 255) << "a foot behind a rail";
  EXPECT_EQ(*actor.mask.at(80, 30), 0);
  EXPECT_GT(actor.other, 1);
  EXPECT_EQ(*ChooseActor(regions, {}).mask.at(80, 30), 255) << "the largest, if nothing is known";
}

}  // namespace keypose::capture::actor_regions_test
