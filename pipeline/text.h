// Text in many languages: names, and lines that fit a terminal. All text is UTF-8.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace keypose::pipeline {

bool IsUtf8(const std::string& text);

/// The same letters in one spelling (NFC): an 'a' followed by two dots, as macOS writes an umlaut
/// in file names, becomes the umlaut. Text that is not UTF-8 comes back as it is.
std::string Composed(const std::string& text);

/// Whether folders, steps and flags can be named so: letters and digits of any script, '-' and '_';
/// no '-' at the start.
bool IsName(const std::string& text);
/// What IsName allows, for messages.
inline const char* const kNameRule = "letters, digits, '-' and '_' only";

/// Columns that the text takes on a terminal.
std::size_t WidthOf(const std::string& text);
/// As much of the text as fits into so many columns; no letter is cut in two.
std::string CutTo(const std::string& text, std::size_t columns);
/// Lines of at most so many columns, broken at spaces; a longer word has a line of its own. 0: one
/// line.
std::vector<std::string> Wrapped(const std::string& text, std::size_t columns);

/// The text as one word of a shell's command line.
std::string ShellWord(const std::string& text);

}  // namespace keypose::pipeline
