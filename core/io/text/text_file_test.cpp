#include "core/io/text/text_file.h"

#include <gtest/gtest.h>

#include "core/testing/folder.h"

namespace keypose::text_file_test {

using std::string_literals::operator""s;

TEST(TextFile, Utf16IsReadInBothOrders) {
  EXPECT_EQ(FromUtf16("\xff\xfe\x3d\xd8\x00\xde"s), "\xf0\x9f\x98\x80");  // U+1F600
  EXPECT_EQ(FromUtf16("\xfe\xff\0A\0\xfc"s), "A\xc3\xbc");
  EXPECT_EQ(FromUtf16("A\0B\0"s), "AB");
  EXPECT_EQ(FromUtf16("\0A\0B"s), "AB");
  EXPECT_EQ(FromUtf16("HIERARCHY"), "");
}

TEST(TextFile, AByteOrderMarkIsNoPartOfTheText) {
  EXPECT_EQ(PlainText("\xEF\xBB\xBF# Camera list"), "# Camera list");
  EXPECT_EQ(PlainText("plain"), "plain");
  EXPECT_EQ(PlainText(""), "");
  const TestingFolder folder;
  EXPECT_EQ(ReadTextFile(folder.Put("wide.txt",
                                    "\xff\xfe"
                                    "1\0 \0"s)),
            "1 ");
}

}  // namespace keypose::text_file_test
