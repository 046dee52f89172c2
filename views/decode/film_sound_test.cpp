// The sound of films: when it is loud, by the clock of their pictures.
#include "views/decode/film_sound.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <limits>

#include "core/io/text/files.h"
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

TEST_F(FilmSoundOf, AJumpOfItsTimesTakesNoMemory) {
  const fs::path path = folder_ / "jump.mkv";
  {
    TestFilm film(path, Kind());
    film.AddSound(Clap(0.5, 1));
    film.AddSound(Clap(0.5, 1), std::int64_t{26 * 3600} * kRate);
    AddPictures(film);
  }
  const FilmSound sound = ReadFilmSound(path, ReadFilmIndex(path), 60);
  EXPECT_EQ(sound.per_milli.size(), 1000u);
  EXPECT_NEAR(LoudestAt(sound), 0.5, 1.5e-3);
}

TEST_F(FilmSoundOf, TheBoundIsCountedFromTheFirstSample) {
  const fs::path path = folder_ / "late.mkv";
  {
    TestFilm film(path, Kind());
    film.AddSound(Clap(0.25, 2), 5 * kRate);
    AddPictures(film);
  }
  const FilmSound sound = ReadFilmSound(path, ReadFilmIndex(path), 0.5);
  EXPECT_NEAR(sound.first_s, 5, 1e-3);
  EXPECT_NEAR(static_cast<double>(sound.per_milli.size()), 500, 1);
  EXPECT_NEAR(LoudestAt(sound), 5.25, 1.5e-3);
}

/// A WAVE of floats, of one channel.
std::string Wave(const std::vector<float>& samples) {
  std::string bytes = "RIFF";
  const auto add = [&](auto number) {
    bytes.append(reinterpret_cast<const char*>(&number), sizeof number);
  };
  const auto size = static_cast<std::uint32_t>(4 * samples.size());
  add(36 + size), bytes += "WAVEfmt ", add(std::uint32_t{16});
  add(std::uint16_t{3}), add(std::uint16_t{1}), add(std::uint32_t{kRate});
  add(std::uint32_t{4 * kRate}), add(std::uint16_t{4}), add(std::uint16_t{32});
  bytes += "data", add(size);
  for (const float sample : samples) add(sample);
  return bytes;
}

TEST_F(FilmSoundOf, SamplesThatAreNoNumbersAreLeftOut) {
  std::vector<float> samples(kRate, 0.25f);
  samples[800] = std::numeric_limits<float>::quiet_NaN();
  samples[1600] = std::numeric_limits<float>::infinity();
  samples[2400] = 1e30f;
  WriteFile(folder_ / "a.wav", Wave(samples));
  const FilmSound sound = ReadFilmSound(folder_ / "a.wav", {}, 60);
  ASSERT_EQ(sound.per_milli.size(), 1000u);
  for (const float power : sound.per_milli) ASSERT_EQ(power, 0.0625f);
}

}  // namespace keypose::film_sound_test
