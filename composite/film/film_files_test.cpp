#include "composite/film/film_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/io/text/files.h"
#include "core/testing/folder.h"
#include "views/decode/testing/test_film.h"

namespace keypose::composite::film_files_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class FilmFilesTest : public ::testing::Test, public TestingFolder {};

TEST_F(FilmFilesTest, WideColoursOfAVideoAreSaid) {
  if (!TestFilm::CanWrite("libx264")) GTEST_SKIP() << "libavcodec has no x264 here";
  std::filesystem::create_directories(folder_);
  TestFilmKind kind;
  kind.codec = "libx264";
  WriteTestFilm(folder_ / "plain.mkv", kind, EvenTimes(5, 3000));
  EXPECT_THAT(FilmFiles(folder_ / "plain.mkv").notes(), IsEmpty());
  kind.codec_options = {{"x264-params", "colorprim=bt2020"}};
  WriteTestFilm(folder_ / "wide.mkv", kind, EvenTimes(5, 3000));
  EXPECT_THAT(FilmFiles(folder_ / "wide.mkv").notes(),
              ElementsAre(HasSubstr("the video wide.mkv has the wide colours of 'bt2020'")));
}

TEST_F(FilmFilesTest, LightIsToldByNamesWithoutOpeningAVideo) {
  for (const char* name : {"light/a.1002.exr", "light/a.1001.exr", "levels/1.png", "one.DPX"}) {
    std::filesystem::create_directories((folder_ / name).parent_path());
    WriteFile(folder_ / name, "x");
  }
  WriteFile(folder_ / "broken.mkv", "no film at all");
  const std::vector<FilmPicture> light = LightPictures(folder_ / "light");
  ASSERT_EQ(light.size(), 2u);
  EXPECT_EQ(light[0].path, folder_ / "light/a.1001.exr");
  EXPECT_EQ(light[1].number, 1002);
  EXPECT_TRUE(FilmFiles(folder_ / "light").is_light());
  EXPECT_EQ(LightPictures(folder_ / "one.DPX").size(), 1u);
  EXPECT_THAT(LightPictures(folder_ / "levels"), IsEmpty());
  EXPECT_THAT(LightPictures(folder_ / "broken.mkv"), IsEmpty());
}

}  // namespace keypose::composite::film_files_test
