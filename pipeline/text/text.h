// Text in many languages: names, and lines that fit a terminal. All text is UTF-8.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace keypose::pipeline {

bool IsUtf8(const std::string& text);

/// The text in Unicode normal form NFC: an 'a' followed by a combining diaeresis, as in macOS file
/// names, becomes the umlaut. Text that is not UTF-8 is returned unchanged.
std::string Composed(const std::string& text);

/// Whether the text is a valid name of a folder, step or flag: letters and digits of any script,
/// '-' and '_'; no '-' at the start.
bool IsName(const std::string& text);
/// The rule of IsName, for messages.
inline const char* const kNameRule = "letters, digits, '-' and '_' only";

/// Columns that the text takes on a terminal.
std::size_t WidthOf(const std::string& text);
/// The longest prefix of whole letters that fits into `columns`.
std::string CutTo(const std::string& text, std::size_t columns);
/// Lines of at most `columns`, broken at spaces. A longer word gets its own line. 0: one line.
std::vector<std::string> Wrapped(const std::string& text, std::size_t columns);

/// The text quoted as one word for a shell.
std::string ShellWord(const std::string& text);

/// "1.2 GB", "3.4 MB", "5 kB"
std::string SizeText(std::uint64_t bytes);

}  // namespace keypose::pipeline
