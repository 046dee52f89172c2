// How much moves in films.
#include "views/decode/film_motion.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/testing/folder.h"
#include "views/decode/testing/test_film.h"

namespace keypose::film_motion_test {

using ::testing::Each;

class FilmMotionOf : public ::testing::Test, public TestingFolder {
 protected:
  /// Half of each second picture has another entry of the palette.
  FilmMotion OfPalette(std::uint32_t entry, std::uint32_t other) {
    std::filesystem::create_directories(folder_);
    TestFilmKind kind;
    kind.codec = "png", kind.pixels = AV_PIX_FMT_PAL8;
    {
      TestFilm film(folder_ / "a.mov", kind);
      for (int n = 0; n < 5; ++n)
        film.Add(3000 * n, [&](AVFrame& frame) {
          auto* palette = reinterpret_cast<std::uint32_t*>(frame.data[1]);
          std::fill_n(palette, 256, 0xff000000u);
          palette[7] = entry, palette[207] = other;
          for (int y = 0; y < frame.height; ++y)
            for (int x = 0; x < frame.width; ++x)
              frame.data[0][y * frame.linesize[0] + x] = x < 64 && n % 2 ? 207 : 7;
        });
      film.Finish();
    }
    return ReadFilmMotion(folder_ / "a.mov", ReadFilmIndex(folder_ / "a.mov"), 60);
  }
};

TEST_F(FilmMotionOf, APaletteIsLookedUp) {
  const FilmMotion none = OfPalette(0xff404040, 0xff404040),
                   some = OfPalette(0xff404040, 0xff4a4a4a);
  ASSERT_EQ(none.values.size(), 4u);
  EXPECT_THAT(none.values, Each(0.0)) << "two entries of one colour";
  ASSERT_EQ(some.values.size(), 4u);
  // Ten levels in half of the picture are five from the mean, in a thirtieth of a second.
  for (const double value : some.values) EXPECT_NEAR(value, std::sqrt(5 * 30.0), 1e-3);
}

}  // namespace keypose::film_motion_test
