// What films say of their pictures: times, rates, and what is refused.
#include "views/decode/film_index.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/io/pictures/image_io.h"
#include "core/io/text/files.h"
#include "core/testing/folder.h"
#include "core/values/errors.h"
#include "views/decode/testing/test_film.h"

namespace keypose::film_index_test {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

constexpr int kStep = 3000;  // of 90000 in a second: 30 pictures a second

class Films : public ::testing::Test, public TestingFolder {
 protected:
  FilmIndex Index(const std::string& name, const TestFilmKind& kind,
                  const std::vector<std::int64_t>& times) const {
    fs::create_directories(folder_);
    WriteTestFilm(folder_ / name, kind, times);
    return ReadFilmIndex(folder_ / name);
  }
  std::string Fault(const std::string& name, const TestFilmKind& kind) const {
    try {
      Index(name, kind, EvenTimes(5, kStep));
    } catch (const InputError& error) {
      return error.what();
    }
    return "none";
  }
  static TestFilmKind H264() {
    TestFilmKind kind;
    kind.codec = "libx264";
    return kind;
  }
  void RequireX264() const {
    if (!TestFilm::CanWrite("libx264")) GTEST_SKIP() << "libavcodec has no x264 here";
  }
};

TEST_F(Films, ContainersOfAllKindsHaveTheSamePictures) {
  if (!TestFilm::CanWrite("libx264")) GTEST_SKIP() << "libavcodec has no x264 here";
  TestFilmKind live = H264(), pieces = H264();
  live.format_options = {{"live", "1"}};
  pieces.format_options = {{"movflags", "frag_keyframe+empty_moov"}};
  const std::vector<std::pair<std::string, TestFilmKind>> kinds{
      {"a.mp4", H264()},  {"a.mov", H264()}, {"a.mkv", H264()},
      {"live.mkv", live}, {"a.ts", H264()},  {"pieces.mp4", pieces}};
  for (const auto& [name, kind] : kinds) {
    const FilmIndex index = Index(name, kind, EvenTimes(40, kStep));
    ASSERT_EQ(index.frames(), 40) << name;
    EXPECT_EQ(index.rate.per_second, 30) << name;
    EXPECT_TRUE(index.rate.constant) << name;
    EXPECT_EQ(index.width, 128);
    EXPECT_EQ(index.height, 32);
    EXPECT_FALSE(index.has_alpha);
    EXPECT_EQ(index.codec, "h264");
    for (int i = 0; i < 40; ++i) EXPECT_NEAR(index.times_s[i], i / 30.0, 6e-4) << name << i;
  }
}

TEST_F(Films, AnAviIsCounted) {
  TestFilmKind kind;
  kind.codec = "mjpeg", kind.pixels = AV_PIX_FMT_YUVJ420P, kind.unit = 25, kind.rate = 25;
  const FilmIndex index = Index("a.avi", kind, EvenTimes(7, 1));
  EXPECT_EQ(index.frames(), 7);
  EXPECT_EQ(index.rate.per_second, 25);
}

TEST_F(Films, OfABareStreamTheRateIsInventedAndSaid) {
  TestFilmKind kind;
  kind.codec = "mjpeg", kind.pixels = AV_PIX_FMT_YUVJ420P, kind.unit = 12, kind.rate = 12;
  const FilmIndex index = Index("a.mjpeg", kind, EvenTimes(7, 1));
  EXPECT_EQ(index.frames(), 7);
  EXPECT_EQ(index.rate.per_second, 25) << "libavformat's own";
  ASSERT_EQ(index.notes.size(), 1u);
  EXPECT_THAT(index.notes[0], HasSubstr("has no times and no rate"));
}

TEST_F(Films, OfAnAviThatStoresPicturesInAnotherOrderToo) {
  if (!TestFilm::CanWrite("libx264")) GTEST_SKIP() << "libavcodec has no x264 here";
  TestFilmKind kind = H264();
  kind.unit = 30;
  const FilmIndex index = Index("a.avi", kind, EvenTimes(40, 1));
  ASSERT_EQ(index.frames(), 40);
  EXPECT_EQ(index.rate.per_second, 30);
  EXPECT_TRUE(index.rate.constant);
}

TEST_F(Films, PicturesThatAreMissingTakeTime) {
  std::vector<std::int64_t> times = EvenTimes(60, kStep);
  for (const int lost : {40, 30, 29, 28, 27, 12, 10, 8}) times.erase(times.begin() + lost);
  const FilmIndex index = Index("a.mkv", TestFilmKind{}, times);
  EXPECT_FALSE(index.rate.constant);
  EXPECT_EQ(index.rate.per_second, 30);
  const std::vector<int> numbers = FrameNumbers(index.times_s, index.rate);
  ASSERT_EQ(numbers.size(), times.size());
  for (std::size_t i = 0; i < times.size(); ++i) EXPECT_EQ(numbers[i], times[i] / kStep);
}

TEST_F(Films, ALateStartIsPartOfTheTimes) {
  const FilmIndex index = Index("a.mov", TestFilmKind{}, EvenTimes(10, kStep, 15 * kStep));
  EXPECT_NEAR(index.times_s.front(), 0.5, 1e-6);
  EXPECT_TRUE(index.rate.constant);
  const FilmIndex broadcast = Index(
      "a.ts",
      [] {
        TestFilmKind kind;
        kind.codec = "mpeg2video", kind.unit = 30;
        return kind;
      }(),
      EvenTimes(10, 1, 500));
  EXPECT_NEAR(broadcast.times_s.front(), 0, 0.04) << "which counts from anywhere";
}

TEST_F(Films, APictureIsFoundByItsTime) {
  FilmIndex index;
  index.times_s = {0.5, 0.6, 1.0};
  EXPECT_EQ(index.PictureAt(0.2), 0);
  EXPECT_EQ(index.PictureAt(0.5), 0);
  EXPECT_EQ(index.PictureAt(0.6 - 1e-9), 1) << "rounding is no difference";
  EXPECT_EQ(index.PictureAt(0.99), 1);
  EXPECT_EQ(index.PictureAt(7), 2);
  EXPECT_EQ(index.PictureNearest(0.99), 2);
  EXPECT_EQ(index.PictureNearest(0.79), 1);
  EXPECT_EQ(index.PictureNearest(-3), 0);
  EXPECT_EQ(index.PictureNearest(9), 2);
}

TEST_F(Films, WhatIsNotReadIsNamed) {
  TestFilmKind kind;
  kind.aspect = {4, 3};
  EXPECT_THAT(Fault("a.mkv", kind), HasSubstr("pixels that are not square (4:3)"));
  kind.aspect = {1, 1};
  EXPECT_EQ(Fault("b.mkv", kind), "none");
  kind.fields = AV_FIELD_TT;
  EXPECT_THAT(Fault("c.mov", kind), HasSubstr("is interlaced"));
  kind.fields = AV_FIELD_PROGRESSIVE;
  EXPECT_EQ(Fault("d.mov", kind), "none");
  kind.transfer = AVCOL_TRC_SMPTE2084;
  EXPECT_THAT(Fault("e.mkv", kind), HasSubstr("HDR (PQ"));
  kind.transfer = AVCOL_TRC_ARIB_STD_B67;
  EXPECT_THAT(Fault("f.mkv", kind), HasSubstr("HDR (HLG"));
  kind.transfer = AVCOL_TRC_BT709;
  kind.turn = {56756, 32768, 0, -32768, 56756, 0, 0, 0, 1 << 30};
  EXPECT_THAT(Fault("g.mov", kind), HasSubstr("turned by 30.0 degrees"));
}

TEST_F(Films, NoFilmAndHalfAFilmAreNamed) {
  fs::create_directories(folder_);
  const fs::path text = folder_ / "a.mkv";
  WriteFile(text, "no film at all, only words");
  EXPECT_THROW(ReadFilmIndex(text), InputError);
  EXPECT_THROW(ReadFilmIndex(folder_ / "nothing.mkv"), DiskError);
  const fs::path list = folder_ / "list.mp4";
  WriteFile(list, "#EXTM3U\n#EXTINF:1,\na.mkv\n");
  EXPECT_THROW(ReadFilmIndex(list), InputError) << "a list of other files";
  WriteImage(folder_ / "photo.jpg", Image8(16, 16, 3));
  fs::rename(folder_ / "photo.jpg", folder_ / "photo.mkv");
  EXPECT_THROW(ReadFilmIndex(folder_ / "photo.mkv"), InputError) << "a film of one picture";
}

TEST_F(Films, PicturesAreNoFilms) {
  fs::create_directories(folder_);
  for (const char* name : {"a.png", "a.HEIC", "a.mkv", "a"}) WriteFile(folder_ / name, "x");
  EXPECT_FALSE(IsFilmFile(folder_ / "a.png"));
  EXPECT_FALSE(IsFilmFile(folder_ / "a.HEIC"));
  EXPECT_TRUE(IsFilmFile(folder_ / "a.mkv"));
  EXPECT_TRUE(IsFilmFile(folder_ / "a"));
  EXPECT_FALSE(IsFilmFile(folder_));
}

}  // namespace keypose::film_index_test
