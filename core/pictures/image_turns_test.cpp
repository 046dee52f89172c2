#include "core/pictures/image_turns.h"

#include <gtest/gtest.h>

#include <array>

#include "core/testing/waves.h"

namespace keypose::image_turns_test {

TEST(Oriented, EachOfTheEightWaysIsUndone) {
  Image8 stored(3, 2, 1);
  std::copy_n("abcdef", 6, stored.data.begin());
  const std::array<std::string, 9> upright = {"",       "abcdef", "cbafed", "fedcba", "defabc",
                                              "adbecf", "daebfc", "fcebda", "cfbead"};
  for (int way = 1; way <= 8; ++way) {
    const Image8 image = Oriented(stored, way);
    EXPECT_EQ(image.width, way < 5 ? 3 : 2);
    EXPECT_EQ(std::string(image.data.begin(), image.data.end()), upright[way]) << way;
  }
  // Larger than the squares in which pixels are moved.
  const Image8 waves = Waves(75, 41);
  EXPECT_EQ(Oriented(Oriented(waves, 6), 8).data, waves.data);
  EXPECT_EQ(Oriented(Oriented(waves, 7), 7).data, waves.data);
}

}  // namespace keypose::image_turns_test
