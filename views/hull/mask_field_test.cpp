#include "views/hull/mask_field.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace keypose::mask_field_test {

TEST(MaskField, IsTheDistanceToTheNearestPixelOfTheOtherKind) {
  std::mt19937 random(1);
  for (const int rarity : {2, 9, 300}) {
    constexpr int kWidth = 43, kHeight = 31;
    PreparedView view;
    view.levels.push_back({{kWidth, kHeight, 1, 1, 0, 0}, GreyMask(kWidth, kHeight, 1)});
    GreyMask& mask = view.levels[0].grey;
    for (std::uint16_t& pixel : mask.data) pixel = random() % rarity == 0;
    const MaskField field = MakeMaskField(view, 0);
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        int nearest = 1 << 30;
        for (int v = 0; v < kHeight; ++v)
          for (int u = 0; u < kWidth; ++u)
            if (*mask.at(u, v) != *mask.at(x, y))
              nearest = std::min(nearest, (u - x) * (u - x) + (v - y) * (v - y));
        const float outside = std::sqrt(static_cast<float>(nearest)) - 0.5f;
        EXPECT_EQ(field.At(x, y), *mask.at(x, y) ? -outside : outside) << x << "," << y;
      }
  }
}

}  // namespace keypose::mask_field_test
