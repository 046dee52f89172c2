#include "core/values/file_names.h"

#include <gtest/gtest.h>

#include <string_view>

namespace keypose::file_names_test {

TEST(IsOneName, RefusesWhatLeadsElsewhere) {
  for (const char* good : {"a", "IMG_1.JPG", "...", ".hidden", "a b"}) EXPECT_TRUE(IsOneName(good));
  for (const char* bad : {"", ".", "..", "a/b", "/", "a/"}) EXPECT_FALSE(IsOneName(bad)) << bad;
  EXPECT_FALSE(IsOneName(std::string_view("a\0b", 3)));
}

TEST(StaysBelow, HoldsForEachPart) {
  for (const char* good : {"a", "a/b.png"}) EXPECT_TRUE(StaysBelow(good)) << good;
  for (const char* bad : {"", "/a", "a/../b", "../a", "a//b", "a/."})
    EXPECT_FALSE(StaysBelow(bad)) << bad;
}

TEST(IsWithin, ComparesWholeNames) {
  EXPECT_TRUE(IsWithin("/a/b", "/a/b"));
  EXPECT_TRUE(IsWithin("/a/b/c", "/a/b"));
  EXPECT_FALSE(IsWithin("/a/bc", "/a/b"));
  EXPECT_FALSE(IsWithin("/a", "/a/b"));
}

TEST(LowerCase, ChangesLettersOfAsciiOnly) {
  EXPECT_EQ(LowerCase("IMG_\xC3\x96.JPG"), "img_\xC3\x96.jpg");
  EXPECT_EQ(LowerExtension("shots/IMG_1.JPG"), ".jpg");
  EXPECT_EQ(LowerExtension("README"), "");
}

}  // namespace keypose::file_names_test
