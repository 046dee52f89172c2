// Reads and writes whole files. Checks for UTF-8 and JSON texts.
#pragma once

#include <exception>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace keypose {

/// The content of a regular file, or of a link to one. Pipes and devices are refused, because they
/// may never end.
/// @throws DiskError
std::string ReadFile(const std::filesystem::path& path);
/// Writes the file and checks that every byte was written. Does not call fsync.
/// @throws DiskError  names the path and the system's reason
void WriteFile(const std::filesystem::path& path, std::string_view text);
/// Writes to a temporary file in the same folder and renames it, so that the file is either
/// complete or unchanged.
/// @throws DiskError
void WriteFileAtomically(const std::filesystem::path& path, std::string_view text);

/// Whether `text` can be written to JSON: valid UTF-8 without overlong forms and surrogates.
bool IsValidUtf8(std::string_view text);
/// `text` with a question mark in place of each byte that is not valid UTF-8.
std::string WithoutOddBytes(std::string text);
/// A file's name for a message. Bytes that are not valid UTF-8 are written as \xNN.
std::string PrintableName(const std::filesystem::path& path);

/// Whether the brackets of a JSON text are nested at most 100 levels deep, so that a recursive
/// parser cannot overflow the stack.
bool IsShallowJson(std::string_view text);
/// @throws InputError  !IsShallowJson(text); names `where`
void RequireShallowJson(std::string_view text, const std::string& where);
/// The error message of the JSON library, without the prefix in brackets that names the library's
/// exception.
std::string JsonFault(const std::exception& error);

/// The entry of `words` with the smallest edit distance to `word`, for "did you mean".
std::string NearestWord(const std::string& word, const std::vector<std::string>& words);

}  // namespace keypose
