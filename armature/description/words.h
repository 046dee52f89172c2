// Words of a description file, with all that stands between them, so that the file can be written
// back as it was.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace keypose::armature {

struct Word {
  std::string before;  ///< spaces and comments before the word
  std::string text;    ///< empty for the end of the file
  int line = 1, column = 1;
};

/// A place in a file, for messages: "leg.txt:12:3: ...".
/// @throws InputError  always
[[noreturn]] void FailAt(const std::string& file, const Word& word, const std::string& what);

/// Splits a text into words. Braces are words of their own, `#` begins a comment that ends with the
/// line. The last word is the end of the file.
/// @throws InputError  more than 16 MB; a byte that no text has; names line and column
std::vector<Word> SplitWords(std::string_view text, const std::string& file);

/// The text that was split, to the byte.
std::string JoinWords(const std::vector<Word>& words);

/// A word as it is shown in a message: cut off where it is long, quoted.
std::string Quoted(const std::string& word);

/// "; did you mean 'scale'?", or nothing when nothing is known.
std::string DidYouMean(const std::string& word, const std::vector<std::string>& known);

/// Reads the words of one file one after another; all its faults name file, line and column.
class WordReader {
 public:
  /// @param words  from SplitWords; must outlive this
  WordReader(const std::vector<Word>& words, const std::string& file)
      : words_(words), file_(file) {}

  const Word& Peek() const { return words_[at_]; }
  bool AtEnd() const { return Peek().text.empty(); }
  /// Place of the next word in the file's list.
  std::size_t at() const { return at_; }
  /// The next word; the end stays the end.
  const Word& Next();
  /// @throws InputError  another word
  void Expect(const std::string& text);
  /// A word that is no brace.
  /// @param what  it is, for the message
  std::string Name(const std::string& what);
  /// A finite number of at most 1e9.
  double Number(const std::string& what);
  /// A whole number in [low, high].
  int Whole(const std::string& what, int low, int high);
  /// "'scal' is not known here; did you mean 'scale'?"
  /// @throws InputError  always
  [[noreturn]] void RefuseWord(const Word& word, const std::vector<std::string>& known) const;
  [[noreturn]] void Fail(const Word& word, const std::string& what) const {
    FailAt(file_, word, what);
  }

 private:
  const std::vector<Word>& words_;
  const std::string& file_;
  std::size_t at_ = 0;
};

}  // namespace keypose::armature
