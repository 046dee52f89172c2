#include "core/io/pictures/blurred_images.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace keypose::blurred_images_test {

TEST(BlurredImages, AreThoseFarLessCrispThanTheOthers) {
  ImageSet set;
  for (const auto& [name, crispness] :
       {std::pair{"a", 0.6}, {"b", 0.62}, {"c", 0.44}, {"d", 0.61}, {"e", 0.0}, {"f", 0.55}}) {
    CapturedImage image;
    image.name = name;
    image.crispness = crispness;
    set.images.push_back(image);
  }
  EXPECT_THAT(BlurredImages(set), ::testing::ElementsAre("c"));
  for (CapturedImage& image : set.images) image.crispness = 0;
  EXPECT_TRUE(BlurredImages(set).empty());
}

}  // namespace keypose::blurred_images_test
