#include "pipeline/text/text.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <string>
#include <vector>

namespace keypose::pipeline::text_test {

TEST(Text, ALetterWithItsMarkBecomesOneAndWhatIsNoUtf8Stays) {
  EXPECT_EQ(Composed("a\xcc\x88rger"), "\xc3\xa4rger");
  EXPECT_EQ(Composed("\xff!"), "\xff!");
  EXPECT_TRUE(IsUtf8("\xc3\xa4rger"));
  EXPECT_FALSE(IsUtf8("\xc3"));
}

TEST(Text, NamesHaveLettersOfAnyScriptAndDoNotBeginLikeAFlag) {
  for (const char* name : {"bent", "pose_2", "left-arm", "\xc3\xa4rger", "\xe6\x97\xa5"})
    EXPECT_TRUE(IsName(name)) << name;
  for (const char* name : {"", "-bent", "a b", "a/b", "a.b", "\xff"})
    EXPECT_FALSE(IsName(name)) << name;
}

TEST(Text, WidthsAreThoseOfATerminal) {
  EXPECT_EQ(WidthOf("abc"), 3u);
  EXPECT_EQ(WidthOf("\xc3\xa4"), 1u);
  EXPECT_EQ(WidthOf("\xe6\x97\xa5"), 2u);
  EXPECT_EQ(CutTo("\xe6\x97\xa5\xe6\x97\xa5", 3), "\xe6\x97\xa5");
  EXPECT_EQ(CutTo("abc", 9), "abc");
}

TEST(Text, LinesBreakAtSpacesAndLongWordsStayWhole) {
  const std::vector<std::string> lines = Wrapped("one two three incomprehensible end", 9);
  const std::vector<std::string> expected = {"one two", "three", "incomprehensible", "end"};
  EXPECT_EQ(lines, expected);
  EXPECT_EQ(Wrapped("one two three", 0).size(), 1u);
}

TEST(Text, AShellWordIsReadBackByAShell) {
  for (const std::string word : {"plain", "two words", "it's", "$HOME `x`", ""}) {
    std::FILE* const shell = ::popen(("printf %s " + ShellWord(word)).c_str(), "r");
    ASSERT_NE(shell, nullptr);
    char read[64] = {};
    const std::size_t size = std::fread(read, 1, sizeof read - 1, shell);
    ::pclose(shell);
    EXPECT_EQ(std::string(read, size), word);
  }
}

}  // namespace keypose::pipeline::text_test
