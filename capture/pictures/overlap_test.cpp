#include "capture/pictures/overlap.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace keypose::capture::overlap_test {

/// Patches of random grey, 9 pixels wide; `shift` moves them, `pattern` selects them.
Preview Patches(int pattern, int shift) {
  Preview preview{Image8(320, 240, 1), Image8(320, 240, 1, 255)};
  for (int y = 0; y < 240; ++y)
    for (int x = 0; x < 320; ++x) {
      const auto column = static_cast<std::uint32_t>((x + shift) / 9),
                 row = static_cast<std::uint32_t>(y / 9);
      const std::uint32_t cell =
          column * 73856093U ^ row * 19349663U ^ static_cast<std::uint32_t>(pattern) * 83492791U;
      const std::uint32_t mixed = (cell ^ (cell >> 13)) * 0x5bd1e995U;
      *preview.grey.at(x, y) = static_cast<std::uint8_t>(60 + (mixed >> 15) % 140);
    }
  return preview;
}

TEST(SharedPlaces, JoinsPhotographsOfOneSideAndNotThoseOfTwo) {
  const std::vector<ImageTie> ties =
      SharedPlaces({Patches(1, 0), Patches(2, 0), Patches(1, 5), Patches(2, 5)});
  ASSERT_EQ(ties.size(), 2U);
  EXPECT_EQ(ties[0].first, 0);
  EXPECT_EQ(ties[0].second, 2);
  EXPECT_EQ(ties[1].first, 1);
  EXPECT_EQ(ties[1].second, 3);
}

}  // namespace keypose::capture::overlap_test
