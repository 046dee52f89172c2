#include "views/film/frame_painter.h"

#include <gtest/gtest.h>

#include "views/film/gif.h"

namespace keypose::frame_painter_test {

TEST(Shrunk, MixesLightNotStoredValues) {
  Image8 board(8, 8, 3);
  for (int y = 0; y < 8; ++y)
    for (int x = 0; x < 8; ++x)
      for (int k = 0; k < 3; ++k) board.at(x, y)[k] = (x + y) % 2 * 255;
  const Image8 small = Shrunk(board, 4, 2);
  ASSERT_EQ(small.data.size(), 24u);
  for (const std::uint8_t value : small.data) EXPECT_EQ(value, 188);  // sRGB of half the light
}

TEST(Shrunk, PartsOfPixelsCountByTheirShare) {
  Image8 row(3, 1, 3);
  std::fill(row.at(1, 0), row.at(3, 0), 255);
  const Image8 small = Shrunk(row, 2, 1);  // the first takes one pixel and a half
  EXPECT_EQ(small.at(0, 0)[0], 156);       // sRGB of a third of the light
  EXPECT_EQ(small.at(1, 0)[0], 255);
}

}  // namespace keypose::frame_painter_test
