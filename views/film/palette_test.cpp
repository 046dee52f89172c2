#include "views/film/palette.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <set>

#include "views/film/testing/plain_pictures.h"

namespace keypose::palette_test {

// Each shade between two colours of the palette is a share of both.
TEST(Ditherer, SlowGradientsHaveNoBands) {
  Palette palette;
  palette.colors = {{100, 100, 100}, {108, 108, 108}};
  Image8 ramp(256, 32, 3);
  for (int y = 0; y < 32; ++y)
    for (int x = 0; x < 256; ++x)
      for (int k = 0; k < 3; ++k) ramp.at(x, y)[k] = static_cast<std::uint8_t>(100 + x / 32);
  const Image8 indices = Ditherer(palette).Indices(ramp);
  for (int shade = 0; shade < 8; ++shade) {
    double sum = 0;
    for (int y = 0; y < 32; ++y)
      for (int x = 32 * shade; x < 32 * shade + 32; ++x) sum += *indices.at(x, y);
    EXPECT_NEAR(sum / 1024, shade / 8.0, 0.03) << "level " << 100 + shade;
  }
}

TEST(ColorCounts, FewColoursArriveExactlyAndTheBackgroundFirst) {
  Image8 picture = Flat(20, 20, {246, 247, 249});
  std::copy_n(std::vector<std::uint8_t>{200, 30, 31}.data(), 3, picture.at(3, 3));
  std::copy_n(std::vector<std::uint8_t>{0, 90, 7}.data(), 3, picture.at(4, 9));
  ColorCounts counts;
  counts.Add(picture);
  const Palette palette = counts.Choose(255);
  ASSERT_EQ(palette.colors.size(), 3u);
  EXPECT_EQ(palette.colors[0], (std::array<std::uint8_t, 3>{246, 247, 249}));
  EXPECT_EQ(palette.colors[palette.Nearest({190, 40, 40})],
            (std::array<std::uint8_t, 3>{200, 30, 31}));
  EXPECT_EQ(palette.colors[palette.Nearest({5, 80, 0})], (std::array<std::uint8_t, 3>{0, 90, 7}));
}

TEST(ColorCounts, NeverMoreThanWantedAndAllDifferent) {
  ColorCounts counts;
  counts.Add(BallAt(80));
  for (const int most : {2, 16, 255}) {
    const Palette palette = counts.Choose(most);
    EXPECT_LE(palette.colors.size(), static_cast<std::size_t>(most));
    EXPECT_GT(palette.colors.size(), 0.7 * most);
    const std::set different(palette.colors.begin(), palette.colors.end());
    EXPECT_EQ(different.size(), palette.colors.size());
  }
}

TEST(Ditherer, GrainOfWhatStandsStillDoesNotMove) {
  ColorCounts counts;
  counts.Add(BallAt(80));
  Ditherer ditherer(counts.Choose(16));
  const Image8 before = ditherer.Indices(BallAt(60));
  Image8 shimmering = BallAt(60);
  for (std::size_t i = 0; i < shimmering.data.size(); i += 7) shimmering.data[i] ^= 1;
  EXPECT_EQ(ditherer.Indices(shimmering).data, before.data);
  EXPECT_NE(ditherer.Indices(BallAt(70)).data, before.data);
}

}  // namespace keypose::palette_test
