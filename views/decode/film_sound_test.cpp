// The sound of films: when it is loud, by the clock of their pictures.
#include "views/decode/film_sound.h"

#include <gtest/gtest.h>

#include "core/testing/folder.h"
#include "views/decode/testing/test_film.h"

namespace keypose::film_sound_test {

namespace fs = std::filesystem;

constexpr int kRate = 8000, kStep = 3000, kPictures = 40;

/// One loud millisecond.
std::vector<double> Clap(double at_s, double seconds) {
  std::vector<double> samples(static_cast<std::size_t>(seconds * kRate), 0.0);
  std::fill_n(samples.begin() + static_cast<std::ptrdiff_t>(at_s * kRate), kRate / 1000, 0.5);
  return samples;
}

double LoudestAt(const FilmSound& sound) {
  const auto loudest = std::max_element(sound.per_milli.begin(), sound.per_milli.end());
  return sound.first_s + 1e-3 * static_cast<double>(loudest - sound.per_milli.begin());
}

class FilmSoundOf : public ::testing::Test, public TestingFolder {
 protected:
  void SetUp() override { fs::create_directories(folder_); }
  static TestFilmKind Kind() {
    TestFilmKind kind;
    kind.sound_rate = kRate;
    return kind;
  }
  static void AddPictures(TestFilm& film) {
    for (int n = 0; n < kPictures; ++n) film.AddNumber(std::int64_t{n} * kStep, n);
    film.Finish();
  }
};

TEST_F(FilmSoundOf, ItsClockIsThatOfThePictures) {
  if (!TestFilm::CanWrite("libx264")) GTEST_SKIP() << "libavcodec has no x264 here";
  TestFilmKind whole = Kind(), pieces = Kind();
  whole.codec = pieces.codec = "libx264";
  pieces.format_options = {{"movflags", "frag_keyframe+empty_moov"}};
  const std::vector<std::pair<std::string, TestFilmKind>> kinds{
      {"whole.mov", whole}, {"pieces.mov", pieces}, {"a.mkv", whole}};
  for (const auto& [name, kind] : kinds) {
    {
      TestFilm film(folder_ / name, kind);
      film.AddSound(Clap(0.5, 1.2));
      AddPictures(film);
    }
    const FilmIndex index = ReadFilmIndex(folder_ / name);
    ASSERT_EQ(index.frames(), kPictures) << name;
    EXPECT_NEAR(index.zero_s, name == "pieces.mov" ? 2 / 30.0 : 0, 1e-6) << name;
    EXPECT_NEAR(index.times_s[15], 0.5, 6e-4) << name;
    EXPECT_NEAR(LoudestAt(ReadFilmSound(folder_ / name, index, 60)), 0.5, 1.5e-3) << name;
  }
}

}  // namespace keypose::film_sound_test
