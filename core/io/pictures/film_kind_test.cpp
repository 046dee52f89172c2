#include "core/io/pictures/film_kind.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/io/testing/image_files.h"
#include "core/io/text/files.h"

namespace keypose::film_kind_test {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using std::string_literals::operator""s;

const std::string kMovie = "\0\0\0\x20"s + "ftypisom" + std::string(24, '\0');

class FilmKind : public ImageIo {
 protected:
  fs::path Put(const std::string& name, const std::string& bytes) const {
    WriteFile(folder_ / name, bytes);
    return folder_ / name;
  }
};

TEST_F(FilmKind, ContainersAreKnownByTheirFirstBytes) {
  std::string packets(1000, '\0'), timed(1000, '\0');
  for (std::size_t at = 0; at < packets.size(); at += 188) packets[at] = 0x47;
  for (std::size_t at = 4; at < timed.size(); at += 192) timed[at] = 0x47;
  EXPECT_EQ(FilmKindOf(packets), "MPEG-TS");
  EXPECT_EQ(FilmKindOf(timed), "MPEG-TS");
  EXPECT_EQ(FilmKindOf(kMovie), "MP4 or QuickTime");
  EXPECT_EQ(FilmKindOf("\x1a\x45\xdf\xa3"s), "Matroska or WebM");
  EXPECT_EQ(FilmKindOf("RIFF\1\1\1\1AVI LIST"s), "AVI");
  EXPECT_EQ(FilmKindOf("RIFF\1\1\1\1WAVEfmt "s), "");
  EXPECT_EQ(FilmKindOf("OggS"s + std::string(24, '\0') + "\x80theora"), "Ogg");
  EXPECT_EQ(FilmKindOf("OggS"s + std::string(24, '\0') + "\x01vorbis"), "");
  EXPECT_EQ(FilmKindOf("GIF89a"), "GIF");
  for (const char* brand : {"heic", "mif1", "avif", "crx ", "M4A "})
    EXPECT_EQ(FilmKindOf("\0\0\0\x18"s + "ftyp" + brand + std::string(12, '\0')), "") << brand;
  EXPECT_EQ(FilmKindOf("Once upon a time"), "");
  EXPECT_EQ(FilmKindOf(""), "");
}

TEST_F(FilmKind, FilmsAreFoundByEndingAndContent) {
  for (const char* name : {"a.flv", "a.OGV", "a.gif", "a.y4m", "a.h264", "a.dv", "a.yuv", "a.m2ts",
                           "a.3gp", "a.wmv", "a.vob", "a.MP4", "a.m3u8"})
    EXPECT_TRUE(IsFilm(Put(name, "x"))) << name;
  EXPECT_TRUE(IsFilm(Put("without", kMovie)));
  EXPECT_TRUE(IsFilm(Put("film.dat", kMovie)));
  for (const char* name : {"a.LRV", "a.m4a", "a.mp4.bak", "a.mp4~", "a.cr3", "a.jpg"})
    EXPECT_FALSE(IsFilm(Put(name, kMovie))) << name;
  EXPECT_FALSE(IsFilm(Put("notes.txt", "a film")));
  EXPECT_FALSE(IsFilm(folder_));
}

TEST_F(FilmKind, WhatIsCalledAFilmAndIsNoneIsNamed) {
  EXPECT_EQ(FilmFault(Put("a.mp4", kMovie)), "");
  EXPECT_EQ(FilmFault(Put("b.yuv", "YUV4MPEG2 W4 H4\n")), "");
  EXPECT_THAT(FilmFault(Put("a.yuv", "\x10\x10")), HasSubstr("without their size"));
  EXPECT_THAT(FilmFault(Put("a.m3u8", "#EXTM3U\n")), HasSubstr("is a playlist"));
  EXPECT_THAT(FilmFault(Put("a.webp", "RIFF\x10\0\0\0WEBPVP8X\x0a\0\0\0\x02\0\0\0"s)),
              HasSubstr("animated WebP"));
}

}  // namespace keypose::film_kind_test
