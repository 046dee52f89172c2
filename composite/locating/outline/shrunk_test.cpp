#include "composite/locating/outline/shrunk.h"

#include <gtest/gtest.h>

namespace keypose::composite::shrunk_test {

TEST(Shrunk, KeepsTheMeanAndPlainPictures) {
  Image8 picture(7, 5, 1);
  double sum = 0;
  for (std::size_t i = 0; i < picture.data.size(); ++i)
    picture.data[i] = static_cast<std::uint8_t>(7 * i % 256), sum += picture.data[i];
  const Image8 one = Shrunk(picture, 1, 1);
  EXPECT_NEAR(one.data[0], sum / 35, 0.51);
  const Image8 plain = Shrunk(Image8(9, 9, 3, 77), 4, 3);
  for (const std::uint8_t value : plain.data) EXPECT_EQ(value, 77);
}

}  // namespace keypose::composite::shrunk_test
