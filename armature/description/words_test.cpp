#include "armature/description/words.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <vector>

#include "core/values/errors.h"

namespace keypose::armature::words_test {

using ::testing::HasSubstr;

std::string MessageOf(const std::function<void()>& act) {
  try {
    act();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(SplitWords, BracesAreWordsAndCommentsAreGaps) {
  const auto words = SplitWords("node{ # a leg\n  name hip }", "leg.txt");
  std::vector<std::string> texts;
  for (const Word& word : words) texts.push_back(word.text);
  EXPECT_THAT(texts, ::testing::ElementsAre("node", "{", "name", "hip", "}", ""));
  EXPECT_EQ(words[2].before, " # a leg\n  ");
  EXPECT_EQ(words[2].line, 2);
  EXPECT_EQ(words[2].column, 3);
}

TEST(SplitWords, AreJoinedToTheByte) {
  for (const char* text : {"", "\xEF\xBB\xBF node {\r\n\tname h\xC3\xBC ft }\n# end", "   ", "}{"})
    EXPECT_EQ(JoinWords(SplitWords(text, "leg.txt")), text);
}

TEST(SplitWords, ALetterOfSeveralBytesIsOneColumn) {
  EXPECT_EQ(SplitWords("h\xC3\xBC ft", "leg.txt")[1].column, 4);
}

TEST(SplitWords, BytesThatNoTextHasAreFaultsWithTheirPlace) {
  EXPECT_THAT(MessageOf([] { SplitWords("a\nb\x01", "leg.txt"); }), HasSubstr("leg.txt:2:2: "));
  EXPECT_THAT(MessageOf([] { SplitWords("a \xFF", "leg.txt"); }), HasSubstr("leg.txt:1:3: "));
}

TEST(Quoted, CutsLongWordsOff) {
  EXPECT_EQ(Quoted("hip"), "'hip'");
  EXPECT_EQ(Quoted(std::string(100, 'x')), "'" + std::string(40, 'x') + "...'");
}

TEST(DidYouMean, NamesTheNearestIfThereIsOne) {
  EXPECT_EQ(DidYouMean("scal", {"sensor", "scale"}), "; did you mean 'scale'?");
  EXPECT_EQ(DidYouMean("scal", {}), "");
}

TEST(WordReader, NumbersAreFiniteAndWholeOnesInTheirRange) {
  const std::string file = "leg.txt";
  const auto words = SplitWords("+2.5 1e10 7 7.5 9", file);
  WordReader reader(words, file);
  EXPECT_EQ(reader.Number("scale"), 2.5);
  EXPECT_THROW(reader.Number("scale"), InputError);
  EXPECT_EQ(reader.Whole("sensor", 0, 8), 7);
  EXPECT_THROW(reader.Whole("sensor", 0, 8), InputError);
  EXPECT_THAT(MessageOf([&] { reader.Whole("sensor", 0, 8); }),
              HasSubstr("leg.txt:1:17: sensor must be a whole number from 0 to 8, not '9'"));
}

TEST(WordReader, TheEndStaysTheEnd) {
  const std::string file = "leg.txt";
  const auto words = SplitWords("node", file);
  WordReader reader(words, file);
  reader.Expect("node");
  for (int i = 0; i < 2; ++i) {
    EXPECT_TRUE(reader.AtEnd());
    EXPECT_EQ(reader.Next().text, "");
  }
  EXPECT_THAT(MessageOf([&] { reader.Expect("}"); }), HasSubstr("the file ends where '}'"));
}

TEST(WordReader, ABraceIsNoName) {
  const std::string file = "leg.txt";
  const auto words = SplitWords("{", file);
  WordReader reader(words, file);
  EXPECT_THAT(MessageOf([&] { reader.Name("a name"); }), HasSubstr("a name is missing before '{'"));
}

}  // namespace keypose::armature::words_test
