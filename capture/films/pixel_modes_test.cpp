#include "capture/films/pixel_modes.h"

#include <gtest/gtest.h>

namespace keypose::capture::pixel_modes_test {

TEST(FindPixelModes, TellTheColoursOfAPixelByFrequency) {
  std::vector<Image8> lab;
  for (int k = 0; k < 10; ++k) {
    Image8 frame(2, 1, 3, 100);
    if (k % 5 == 0) frame.data[0] = 200;                     // twice another lightness
    frame.data[5] = static_cast<std::uint8_t>(100 + k % 2);  // noise
    lab.push_back(frame);
  }
  const PixelModes modes = FindPixelModes(lab, 6);
  EXPECT_EQ(modes.of(0)[0].share, 255 * 8 / 10);
  EXPECT_EQ(modes.of(0)[1].share, 255 * 2 / 10);
  EXPECT_EQ(modes.of(0)[1].lab[0], 200);
  EXPECT_EQ(modes.of(1)[0].share, 255);
  EXPECT_EQ(modes.of(1)[1].share, 0);
  for (int k = 0; k < 10; ++k) EXPECT_EQ(modes.labels[k].data[0], k % 5 == 0) << k;
}

}  // namespace keypose::capture::pixel_modes_test
