#include "composite/film/film_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

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

}  // namespace keypose::composite::film_files_test
