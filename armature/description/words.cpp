#include "armature/description/words.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

#include "core/io/text/files.h"
#include "core/values/errors.h"

namespace keypose::armature {
namespace {

constexpr std::size_t kMostBytes = std::size_t{16} << 20;
constexpr std::size_t kLongestShown = 40;

bool IsSpace(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }
bool IsBrace(char c) { return c == '{' || c == '}'; }

/// What some editors put before a text in UTF-8.
constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

/// Walks over a text and counts lines and columns.
class Walker {
 public:
  Walker(std::string_view text, const std::string& file) : text_(text), file_(file) {}

  bool AtEnd() const { return at_ >= text_.size(); }
  char Here() const { return text_[at_]; }
  void Step() {
    const char c = text_[at_++];
    if (c == '\n') {
      ++line_;
      column_ = 1;
    } else if ((static_cast<unsigned char>(c) & 0xC0) != 0x80) {
      ++column_;  // a letter of several bytes is one column
    }
  }
  Word Next() {
    Word word;
    const std::size_t begin = at_;
    SkipGap();
    word.before = text_.substr(begin, at_ - begin);
    word.line = line_;
    word.column = column_;
    const std::size_t start = at_;
    if (!AtEnd() && IsBrace(Here())) {
      Step();
    } else {
      while (!AtEnd() && !IsSpace(Here()) && !IsBrace(Here()) && Here() != '#') StepOverLetter();
    }
    word.text = text_.substr(start, at_ - start);
    // Names go into JSON, which has no other letters.
    if (!IsValidUtf8(word.text))
      FailAt(file_, word, Quoted(word.text) + " is not written in UTF-8; save the file in it");
    return word;
  }

 private:
  void SkipGap() {
    if (at_ == 0 && text_.starts_with(kByteOrderMark)) at_ = kByteOrderMark.size();
    while (!AtEnd() && (IsSpace(Here()) || Here() == '#')) {
      if (Here() == '#')
        while (!AtEnd() && Here() != '\n') Step();
      else
        Step();
    }
  }
  void StepOverLetter() {
    const auto byte = static_cast<unsigned char>(Here());
    if (byte < ' ' || byte == 127) {
      Word place;
      place.line = line_;
      place.column = column_;
      FailAt(file_, place,
             fmt::format("byte {} is in no text; it is not a description file", byte));
    }
    Step();
  }

  std::string_view text_;
  const std::string& file_;
  std::size_t at_ = 0;
  int line_ = 1, column_ = 1;
};

}  // namespace

void FailAt(const std::string& file, const Word& word, const std::string& what) {
  throw InputError(fmt::format("{}:{}:{}: {}", file, word.line, word.column, what));
}

std::vector<Word> SplitWords(std::string_view text, const std::string& file) {
  if (text.size() > kMostBytes) FailAt(file, {}, "it is longer than 16 MB; no armature needs that");
  std::vector<Word> words;
  Walker walker(text, file);
  do {
    words.push_back(walker.Next());
  } while (!words.back().text.empty());
  return words;
}

std::string JoinWords(const std::vector<Word>& words) {
  std::string text;
  for (const Word& word : words) text += word.before + word.text;
  return text;
}

std::string Quoted(const std::string& word) {
  const bool cut = word.size() > kLongestShown;
  return "'" + WithoutOddBytes(cut ? word.substr(0, kLongestShown) + "..." : word) + "'";
}

std::string DidYouMean(const std::string& word, const std::vector<std::string>& known) {
  if (known.empty()) return "";
  return "; did you mean " + Quoted(NearestWord(word.substr(0, kLongestShown), known)) + "?";
}

const Word& WordReader::Next() {
  const Word& word = words_[at_];
  if (!word.text.empty()) ++at_;
  return word;
}

void WordReader::Expect(const std::string& text) {
  const Word& word = Next();
  if (word.text == text) return;
  if (word.text.empty()) Fail(word, fmt::format("the file ends where '{}' is missing", text));
  Fail(word, fmt::format("'{}' belongs here, not {}", text, Quoted(word.text)));
}

std::string WordReader::Name(const std::string& what) {
  const Word& word = Next();
  if (word.text.empty()) Fail(word, fmt::format("the file ends where {} is missing", what));
  if (IsBrace(word.text[0])) Fail(word, fmt::format("{} is missing before '{}'", what, word.text));
  return word.text;
}

double WordReader::Number(const std::string& what) {
  const Word& word = Peek();
  const std::string text = Name(what);
  const char* const begin = text.data() + (text[0] == '+' ? 1 : 0);
  const char* const end = text.data() + text.size();
  double value = 0;
  const auto [last, error] = std::from_chars(begin, end, value);
  if (error != std::errc() || last != end || !(std::abs(value) <= 1e9))
    Fail(word, fmt::format("{} must be a number, not {}", what, Quoted(text)));
  return value;
}

int WordReader::Whole(const std::string& what, int low, int high) {
  const Word& word = Peek();
  const double value = Number(what);
  if (value != std::floor(value) || value < low || value > high)
    Fail(word, fmt::format("{} must be a whole number from {} to {}, not {}", what, low, high,
                           Quoted(word.text)));
  return static_cast<int>(value);
}

void WordReader::RefuseWord(const Word& word, const std::vector<std::string>& known) const {
  if (word.text.empty()) Fail(word, "the file ends within a block; a '}' is missing");
  Fail(word, fmt::format("{} is not known here{} (known: {})", Quoted(word.text),
                         DidYouMean(word.text, known), fmt::join(known, ", ")));
}

}  // namespace keypose::armature
