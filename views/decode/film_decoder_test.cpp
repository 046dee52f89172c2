// Pictures as they are shown: order, turns, alpha; and films of the world, where they are present.
#include "views/decode/film_decoder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fmt/format.h>

#include <cstring>
#include <nlohmann/json.hpp>

#include "core/io/pictures/image_io.h"
#include "core/io/text/files.h"
#include "core/testing/folder.h"
#include "core/testing/paths.h"
#include "core/values/errors.h"
#include "views/decode/testing/test_film.h"

namespace keypose::film_decoder_test {

namespace fs = std::filesystem;

FilmDecoder Opened(const fs::path& path) {
  return {path, std::make_shared<const FilmIndex>(ReadFilmIndex(path))};
}

class Decoder : public ::testing::Test, public TestingFolder {
 protected:
  void SetUp() override { fs::create_directories(folder_); }
};

TEST_F(Decoder, PicturesComeInTheOrderOfShowing) {
  if (!TestFilm::CanWrite("libx264")) GTEST_SKIP() << "libavcodec has no x264 here";
  TestFilmKind kind;
  kind.codec = "libx264";  // stores pictures in another order (B-frames)
  for (const char* name : {"a.mp4", "a.mkv", "a.ts", "a.avi"}) {
    WriteTestFilm(folder_ / name, kind, EvenTimes(60, 3000));
    FilmDecoder film = Opened(folder_ / name);
    ASSERT_EQ(film.index().frames(), 60) << name;
    for (int i = 0; i < 60; ++i) ASSERT_EQ(NumberIn(film.Read(i, 1)), i) << name;
    for (const int i : {0, 59, 31, 30, 32}) EXPECT_EQ(NumberIn(film.Read(i, 3)), i) << name;
    EXPECT_THROW(film.Read(60, 1), UsageError);
    EXPECT_THROW(film.Read(-1, 1), UsageError);
  }
}

TEST_F(Decoder, TheTurnOfTheHeaderIsAppliedOnce) {
  constexpr std::int32_t kOne = 1 << 16, kUnit = 1 << 30;
  // Where the bright corner goes that is stored at the top left, and whether the sides change.
  struct Case {
    DisplayMatrix matrix;
    bool right, bottom, upright;
  };
  const Case cases[] = {{{kOne, 0, 0, 0, kOne, 0, 0, 0, kUnit}, false, false, false},
                        {{0, kOne, 0, -kOne, 0, 0, 0, 0, kUnit}, true, false, true},
                        {{-kOne, 0, 0, 0, -kOne, 0, 0, 0, kUnit}, true, true, false},
                        {{0, -kOne, 0, kOne, 0, 0, 0, 0, kUnit}, false, true, true},
                        {{-kOne, 0, 0, 0, kOne, 0, 0, 0, kUnit}, true, false, false},
                        {{kOne, 0, 0, 0, -kOne, 0, 0, 0, kUnit}, false, true, false}};
  for (const Case& one : cases) {
    TestFilmKind kind;
    kind.turn = one.matrix;
    TestFilm writer(folder_ / "a.mov", kind);
    writer.Add(0, [](AVFrame& frame) {
      for (int y = 0; y < frame.height; ++y)
        for (int x = 0; x < frame.width; ++x)
          frame.data[0][y * frame.linesize[0] + x] = x < 40 && y < 10 ? 220 : 30;
      for (int plane = 1; plane < 3; ++plane)
        std::fill_n(frame.data[plane], frame.linesize[plane] * frame.height / 2, 128);
    });
    writer.Finish();
    FilmDecoder film = Opened(folder_ / "a.mov");
    const Image8 shown = film.Read(0, 1);
    EXPECT_EQ(shown.width, one.upright ? 32 : 128);
    EXPECT_EQ(shown.height, one.upright ? 128 : 32);
    EXPECT_EQ(film.index().width, shown.width);
    EXPECT_EQ(film.index().height, shown.height);
    for (const bool right : {false, true})
      for (const bool bottom : {false, true})
        EXPECT_EQ(*shown.at(right ? shown.width - 3 : 2, bottom ? shown.height - 3 : 2) > 127,
                  right == one.right && bottom == one.bottom);
  }
}

struct AlphaCase {
  const char *codec, *name;
  AVPixelFormat pixels;
  std::vector<std::pair<std::string, std::string>> options;
};

TEST_F(Decoder, AlphaIsKeptToTheBit) {
  const AlphaCase cases[] = {
      {"qtrle", "a.mov", AV_PIX_FMT_ARGB, {}},
      {"png", "a.mov", AV_PIX_FMT_RGBA, {}},
      {"ffv1", "a.mkv", AV_PIX_FMT_YUVA420P, {}},
      {"prores_ks", "a.mov", AV_PIX_FMT_YUVA444P10LE, {{"alpha_bits", "16"}}},
      {"libvpx-vp9", "a.webm", AV_PIX_FMT_YUVA420P, {{"lossless", "1"}}}};
  for (const AlphaCase& one : cases) {
    if (!TestFilm::CanWrite(one.codec)) continue;
    TestFilmKind kind;
    kind.codec = one.codec, kind.pixels = one.pixels, kind.codec_options = one.options;
    kind.width = 256, kind.unit = 1000, kind.rate = 10;
    const AVPixFmtDescriptor* format = av_pix_fmt_desc_get(one.pixels);
    const int alpha = format->nb_components - 1, most = (1 << format->comp[alpha].depth) - 1;
    TestFilm writer(folder_ / one.name, kind);
    writer.Add(0, [&](AVFrame& frame) {
      for (const AVBufferRef* buffer : frame.buf)  // the values are added to what is there
        if (buffer) std::memset(buffer->data, 0, buffer->size);
      for (int c = 0; c < format->nb_components; ++c) {
        const bool chroma = (c == 1 || c == 2) && (format->flags & AV_PIX_FMT_FLAG_RGB) == 0;
        const int width = chroma ? 256 >> format->log2_chroma_w : 256,
                  height = chroma ? 32 >> format->log2_chroma_h : 32;
        std::vector<std::uint16_t> row(static_cast<std::size_t>(width));
        for (int x = 0; x < width; ++x)
          row[x] = static_cast<std::uint16_t>(c == alpha ? (x * most + 127) / 255 : most / 2);
        for (int y = 0; y < height; ++y)
          av_write_image_line2(row.data(), frame.data, frame.linesize, format, 0, y, c, width,
                               sizeof row[0]);
      }
    });
    writer.Finish();
    FilmDecoder film = Opened(folder_ / one.name);
    EXPECT_TRUE(film.index().has_alpha) << one.codec;
    const Image8 shown = film.Read(0, 4);
    for (int x = 0; x < 256; ++x) ASSERT_EQ(shown.at(x, 20)[3], x) << one.codec;
    EXPECT_EQ(FilmLuma(shown).data, film.Read(0, 1).data) << one.codec;
  }
}

TEST_F(Decoder, VariableTimesAndPicturesAtATime) {
  std::vector<std::int64_t> times = EvenTimes(40, 3000);
  for (const int lost : {30, 21, 20, 19, 7}) times.erase(times.begin() + lost);
  TestFilm writer(folder_ / "a.mkv", TestFilmKind{});
  for (const std::int64_t time : times) writer.AddNumber(time, static_cast<int>(time / 3000));
  writer.Finish();
  FilmDecoder film = Opened(folder_ / "a.mkv");
  const auto shown = [&](double time) {
    return NumberIn(film.Read(film.index().PictureAt(time), 1));
  };
  EXPECT_EQ(shown(6.5 / 30), 6);
  EXPECT_EQ(shown(7.5 / 30), 6) << "the one before is still shown";
  EXPECT_EQ(shown(8.5 / 30), 8);
  EXPECT_EQ(shown(21.5 / 30), 18);
  EXPECT_EQ(shown(39.5 / 30), 39);
}

class Stopping : public Progress {
 public:
  void Update(double, std::string_view) override {}
  bool cancelled() const override { return true; }
};

TEST_F(Decoder, StopsWhenAsked) {
  WriteTestFilm(folder_ / "a.mkv", TestFilmKind{}, EvenTimes(5, 3000));
  FilmDecoder film = Opened(folder_ / "a.mkv");
  const Stopping stopping;
  EXPECT_THROW(film.Read(3, 1, &stopping), Cancelled);
  EXPECT_THROW(ReadFilmIndex(folder_ / "a.mkv", &stopping), Cancelled);
}

fs::path Report(const std::string& name) { return DataFolder() / "reports" / name; }

TEST(ReportedFilms, ATurnedFilmLooksAsItsUprightPictures) {
  const fs::path folder = Report("27_video_rotation");
  if (!fs::is_directory(folder)) GTEST_SKIP() << "the data folder is not here";
  for (const char* name : {"rotate_0.mov", "rotate_90.mov"}) {
    FilmDecoder film = Opened(folder / name);
    ASSERT_EQ(film.index().frames(), 12);
    for (int i = 0; i < 12; ++i) {
      const Image8 shown = film.Read(i, 1),
                   upright = ReadImage(folder / fmt::format("upright/{:02}.png", i), 1);
      ASSERT_EQ(shown.width, upright.width);
      ASSERT_EQ(shown.height, upright.height);
      double sum = 0;
      for (std::size_t p = 0; p < shown.data.size(); ++p)
        sum += std::abs(shown.data[p] - upright.data[p]);
      EXPECT_LT(sum / static_cast<double>(shown.data.size()), 4) << name << " " << i;
    }
  }
}

TEST(ReportedFilms, TimesOfVariableAndUncountedFilms) {
  const fs::path folder = Report("28_video_time");
  if (!fs::is_directory(folder)) GTEST_SKIP() << "the data folder is not here";
  const auto truth = nlohmann::json::parse(ReadFile(folder / "truth.json"));
  const FilmIndex dropped = ReadFilmIndex(folder / "variable_dropped.mp4");
  EXPECT_EQ(dropped.rate.per_second, 30);
  EXPECT_FALSE(dropped.rate.constant);
  EXPECT_EQ(FrameNumbers(dropped.times_s, dropped.rate),
            truth["variable_dropped_shows"].get<std::vector<int>>());
  for (const char* name : {"constant_30.mp4", "no_index.webm"}) {
    FilmDecoder film = Opened(folder / name);
    EXPECT_EQ(film.index().frames(), 120) << name;
    EXPECT_EQ(film.index().rate.per_second, 30) << name;
    EXPECT_EQ(film.Read(119, 3).width, 280) << name;
  }
}

}  // namespace keypose::film_decoder_test
