#include "motion/tracking/mask_runs.h"

#include <ceres/ceres.h>
#include <gtest/gtest.h>

namespace keypose::motion::mask_runs_test {

TEST(MaskRuns, GiveTheSameMaskAgain) {
  for (const int rarity : {1, 2, 7, 1000}) {
    Image8 mask(23, 11, 1);
    for (std::size_t i = 0; i < mask.data.size(); ++i) mask.data[i] = (i * i + 3 * i) % rarity == 0;
    const Image8 again = MaskRuns(mask).Mask();
    EXPECT_EQ(again.width, 23);
    EXPECT_EQ(again.height, 11);
    EXPECT_EQ(again.data, mask.data) << rarity;
  }
}

}  // namespace keypose::motion::mask_runs_test
