// Films that are videos: the pictures that are decoded, and files that are no whole video.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "composite/film/film_files.h"
#include "core/io/pictures/image_io.h"
#include "core/io/pictures/image_levels.h"
#include "core/io/pictures/movie_header.h"
#include "core/io/text/files.h"
#include "core/testing/folder.h"
#include "core/values/errors.h"
#include "views/decode/testing/test_film.h"
#include "views/film/mp4.h"
#include "views/shot/shot.h"

namespace keypose::composite::video_film_test {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr int kWidth = 64, kHeight = 48, kFrames = 6;

class Video : public ::testing::Test, public TestingFolder {
 protected:
  void SetUp() override {
    if (!CanWriteMp4()) GTEST_SKIP() << "libavcodec has no x264 here";
    Mp4Writer writer(film_, kWidth, kHeight, 12.5);
    for (int i = 0; i < kFrames; ++i)
      writer.Add(Image8(kWidth, kHeight, 3, static_cast<std::uint8_t>(40 * i)));
    writer.Finish();
  }

  /// What is wrong with a file of these bytes.
  std::string Fault(const std::string& bytes) {
    const fs::path path = folder_ / "other.mp4";
    WriteFile(path, bytes);
    try {
      FilmFiles(path).DecodeAll();
    } catch (const InputError& error) {
      return error.what();
    }
    return "none";
  }

  fs::path film_ = folder_ / "take.mp4";
};

TEST_F(Video, HeaderSaysRateSizeAndCodec) {
  EXPECT_TRUE(IsMovie(film_));
  const MovieHeader header = ReadMovieHeader(film_);
  EXPECT_EQ(header.frames, kFrames);
  EXPECT_NEAR(header.fps, 12.5, 1e-9);
  EXPECT_EQ(header.width, kWidth);
  EXPECT_EQ(header.height, kHeight);
  EXPECT_EQ(header.codec, "avc1");
}

TEST_F(Video, PicturesAreTheDecodersBitForBitAndRemovedAfterwards) {
  FrameSource source;
  source.video = film_, source.frames = kFrames;
  FrameReader reader(source);
  std::vector<fs::path> paths;
  {
    FilmFiles film(film_);
    EXPECT_TRUE(film.is_video());
    EXPECT_NEAR(film.fps(), 12.5, 1e-9);
    ASSERT_EQ(film.pictures().size(), static_cast<std::size_t>(kFrames));
    film.Decode({1, 4});
    EXPECT_FALSE(fs::exists(film.pictures()[0].path)) << "only what is asked for";
    film.DecodeAll();
    for (const FilmPicture& picture : film.pictures()) {
      const Image8 read = ReadImage(picture.path, 3), truth = reader.Read(picture.frame, 3);
      EXPECT_EQ(read.data, truth.data);
      EXPECT_NEAR(*read.at(30, 20), 40 * picture.frame, 4);
      paths.push_back(picture.path);
    }
  }
  for (const fs::path& path : paths) EXPECT_FALSE(fs::exists(path));
  EXPECT_FALSE(fs::exists(paths[0].parent_path()));
}

/// A number of four bytes, highest first.
std::uint32_t NumberAt(const std::string& bytes, std::size_t at) {
  std::uint32_t number = 0;
  for (int i = 0; i < 4; ++i) number = number << 8 | static_cast<unsigned char>(bytes[at + i]);
  return number;
}
void PutNumber(std::string& bytes, std::size_t at, std::uint32_t number) {
  for (int i = 3; i >= 0; --i, number >>= 8) bytes[at + i] = static_cast<char>(number & 255);
}

TEST_F(Video, OfATrimmedFilmOnlyWhatIsShownCounts) {
  // As phones trim: the file keeps its six pictures, and an edit list shows the third to the fifth.
  std::string bytes = ReadFile(film_);
  const std::size_t list = bytes.find("elst"), times = bytes.find("stts"),
                    movie = bytes.find("mvhd");
  ASSERT_NE(list, std::string::npos);
  ASSERT_EQ(NumberAt(bytes, list + 8), 1u) << "one part";
  const std::uint32_t picture = NumberAt(bytes, times + 16), second = NumberAt(bytes, movie + 16);
  PutNumber(bytes, list + 12, second * 3 * 2 / 25);
  PutNumber(bytes, list + 16, NumberAt(bytes, list + 16) + 2 * picture);
  const fs::path trimmed = folder_ / "trimmed.mp4";
  WriteFile(trimmed, bytes);
  const MovieHeader header = ReadMovieHeader(trimmed);
  EXPECT_EQ(header.frames, 3);
  EXPECT_NEAR(header.fps, 12.5, 1e-9);
  FilmFiles film(trimmed);
  film.DecodeAll();
  ASSERT_EQ(film.pictures().size(), 3u);
  for (const FilmPicture& one : film.pictures())
    EXPECT_NEAR(*ReadImage(one.path, 3).at(30, 20), 40 * (one.frame + 2), 4);
  fs::create_directories(folder_ / "shot");
  fs::rename(trimmed, folder_ / "shot/cam1.mp4");
  EXPECT_EQ(OpenShot(folder_ / "shot").cameras.at(0).frames(), 3);
}

TEST_F(Video, OfAFilmThatPlayersTurnTheHeaderSaysTheSizeThatIsShown) {
  // As phones film upright: the pictures lie on their side, and the track's matrix turns them.
  std::string bytes = ReadFile(film_);
  const std::size_t matrix = bytes.find("tkhd") + 4 + 40;
  ASSERT_EQ(NumberAt(bytes, matrix), 0x10000u);
  const std::uint32_t quarter[] = {0, 0x10000, 0, 0xffff0000, 0};
  for (std::size_t i = 0; i < 5; ++i) PutNumber(bytes, matrix + 4 * i, quarter[i]);
  const fs::path turned = folder_ / "turned.mp4";
  WriteFile(turned, bytes);
  const MovieHeader header = ReadMovieHeader(turned);
  EXPECT_EQ(header.width, kHeight);
  EXPECT_EQ(header.height, kWidth);
  FrameSource source;
  source.video = turned, source.frames = kFrames;
  const Image8 shown = FrameReader(source).Read(0, 3);
  EXPECT_EQ(shown.width, header.width);
  EXPECT_EQ(shown.height, header.height);
}

/// Asks to stop when it has been looked at so many times.
class Stopping : public Progress {
 public:
  explicit Stopping(int looks) : left_(looks) {}
  void Update(double, std::string_view) override {}
  bool cancelled() const override { return left_-- <= 0; }

 private:
  mutable int left_;
};

TEST_F(Video, DecodingStopsWhenItIsAskedTo) {
  FilmFiles film(film_);
  Stopping soon(5);
  EXPECT_THROW(film.DecodeAll(&soon), Cancelled);
  EXPECT_TRUE(fs::exists(film.pictures().front().path));
  EXPECT_FALSE(fs::exists(film.pictures().back().path));
  FilmFiles again(film_);
  Stopping on_the_way(4);
  EXPECT_THROW(again.Decode({kFrames - 1}, &on_the_way), Cancelled) << "between wanted frames";
}

TEST_F(Video, AlphaStaysAndWhatIsLeftOutTakesTime) {
  TestFilmKind kind;
  kind.codec = "qtrle", kind.pixels = AV_PIX_FMT_ARGB, kind.unit = kind.rate = 10;
  TestFilm writer(folder_ / "cut_out.mov", kind);
  for (const int time : {0, 1, 2, 3, 5, 6, 9})
    writer.Add(time, [&](AVFrame& frame) {
      for (int y = 0; y < frame.height; ++y)
        for (int x = 0; x < frame.width; ++x)
          for (int c = 0; c < 4; ++c)  // alpha, red, green, blue
            frame.data[0][y * frame.linesize[0] + 4 * x + c] =
                static_cast<std::uint8_t>(c == 0 ? 2 * x + time % 2 : 20 * time + c);
    });
  writer.Finish();
  FilmFiles film(folder_ / "cut_out.mov");
  EXPECT_NEAR(film.fps(), 10, 1e-9);
  film.DecodeAll();
  std::vector<int> frames;
  for (const FilmPicture& picture : film.pictures()) {
    frames.push_back(picture.frame);
    const ImageF color = ReadLevels(picture.path);
    const Image8 alpha = ReadAlpha(picture.path);
    for (int x = 0; x < kind.width; ++x)
      ASSERT_EQ(*alpha.at(x, 7), 2 * x + picture.frame % 2) << picture.frame;
    for (int c = 0; c < 3; ++c) EXPECT_EQ(color.at(90, 7)[c], 20 * picture.frame + c + 1);
  }
  EXPECT_EQ(frames, (std::vector<int>{0, 1, 2, 3, 5, 6, 9}));
}

TEST_F(Video, FoldersStayWhatTheyAre) {
  WriteImage(folder_ / "a_0003.png", Image8(8, 8, 3));
  WriteImage(folder_ / "a_0007.png", Image8(8, 8, 3));
  FilmFiles film(folder_);
  EXPECT_FALSE(film.is_video());
  film.DecodeAll();
  ASSERT_EQ(film.pictures().size(), 2u);
  EXPECT_EQ(film.pictures()[1].frame, 4);
  EXPECT_TRUE(fs::exists(film.pictures()[1].path));
}

TEST_F(Video, CutOffAndDamagedFilesAreNamed) {
  const std::string whole = ReadFile(film_);
  EXPECT_EQ(Fault(whole), "none");
  EXPECT_THAT(Fault(whole.substr(0, whole.size() - 20)),
              AllOf(HasSubstr("other.mp4 is cut off"), HasSubstr("copy or export it again")));
  EXPECT_THAT(Fault(whole.substr(0, 32)), AnyOf(HasSubstr("no index"), HasSubstr("cut off")));
  std::string strange = whole;
  for (std::size_t at; (at = strange.find("avc1", 40)) != std::string::npos;)
    strange.replace(at, 4, "zzzz");
  EXPECT_THAT(Fault(strange), AllOf(HasSubstr("cannot be decoded"), HasSubstr("H.264")));
  std::string silent = whole;
  silent.replace(silent.find("vide"), 4, "soun");
  EXPECT_THAT(Fault(silent), HasSubstr("no video track"));
}

TEST_F(Video, AnyDamageOfTheIndexIsAnErrorOrAFilm) {
  const std::string whole = ReadFile(film_);
  const fs::path path = folder_ / "other.mp4";
  for (std::size_t at = 0; at < std::min<std::size_t>(whole.size(), 720); at += 3)
    for (const char byte : {'\0', '\xff'}) {
      std::string damaged = whole;
      damaged[at] = byte;
      WriteFile(path, damaged);
      try {
        const MovieHeader header = ReadMovieHeader(path);
        EXPECT_GT(header.frames, 0);
        EXPECT_GT(header.fps, 0);
      } catch (const InputError& error) {
        EXPECT_THAT(error.what(), HasSubstr("other.mp4"));
      }
    }
}

}  // namespace keypose::composite::video_film_test
