// Whole files in and out, and folders that appear complete or not at all.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace keypose {

/// @throws DiskError
std::string ReadFile(const std::filesystem::path& path);
/// Writes, syncs nothing, checks every byte was taken. @throws DiskError  names the path and the system's reason
void WriteFile(const std::filesystem::path& path, std::string_view text);
/// Writes to a temporary neighbour and renames it into place. @throws DiskError
void WriteFileAtomically(const std::filesystem::path& path, std::string_view text);

/// Edit distance, for "did you mean".
std::string NearestWord(const std::string& word, const std::vector<std::string>& words);

}  // namespace keypose
