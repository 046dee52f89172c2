#include "core/pictures/cloud_picture.h"

#include <gtest/gtest.h>

#include "core/pictures/testing/from_above.h"

namespace keypose::cloud_picture_test {

TEST(RenderCloud, TheNearestPointIsInFrontInItsOwnColour) {
  PointCloud cloud;
  cloud.points.resize(2, 3);
  cloud.points << 0, 0, 1, 0, 0, 0;  // the view is from above: the first is nearer
  cloud.colors.resize(2, 3);
  cloud.colors << 200, 10, 20, 1, 2, 3;
  const Image8 picture = RenderCloud(cloud, FromAbove());
  EXPECT_EQ(*picture.at(20, 20), 200);
  EXPECT_EQ(*picture.at(5, 5), 247);
}

}  // namespace keypose::cloud_picture_test
