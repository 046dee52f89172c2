// Whole files in and out, and folders that appear complete or not at all.
#pragma once

#include <exception>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace keypose {

/// A regular file, or a link to one: a pipe or a device would never end.
/// @throws DiskError
std::string ReadFile(const std::filesystem::path& path);
/// Writes, syncs nothing, checks every byte was taken.
/// @throws DiskError  names the path and the
/// system's reason
void WriteFile(const std::filesystem::path& path, std::string_view text);
/// Writes to a temporary neighbour and renames it into place.
/// @throws DiskError
void WriteFileAtomically(const std::filesystem::path& path, std::string_view text);

/// Whether `text` can go into JSON: UTF-8 without overlong forms and surrogates.
bool IsValidUtf8(std::string_view text);
/// `text` with a question mark for each byte that is no UTF-8.
std::string WithoutOddBytes(std::string text);
/// A file's name for a message: bytes that are no UTF-8 as \xNN.
std::string PrintableName(const std::filesystem::path& path);

/// Whether brackets in a JSON text are nested so little that code which calls itself for each level
/// has room.
bool IsShallowJson(std::string_view text);
/// @throws InputError  !IsShallowJson(text); names `where`
void RequireShallowJson(std::string_view text, const std::string& where);
/// What a JSON reader says is wrong, for a person: without the library's own name, which comes
/// first in brackets.
std::string JsonFault(const std::exception& error);

/// Edit distance, for "did you mean".
std::string NearestWord(const std::string& word, const std::vector<std::string>& words);

}  // namespace keypose
