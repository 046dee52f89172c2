// Names that come out of files: a file from elsewhere must not name what lies elsewhere.
#pragma once

#include <filesystem>
#include <string_view>

namespace keypose {

/// Whether a text names one file or folder: not empty, no '/' and no NUL in it, neither "." nor
/// "..".
bool IsOneName(std::string_view name);

/// Whether a relative path with '/' stays below the folder that it starts from, links aside: each
/// part as above.
bool StaysBelow(std::string_view path);

/// Whether a path is a folder's or lies below it, by names alone. @pre both normal, and links
/// resolved where these count
bool IsWithin(const std::filesystem::path& inner, const std::filesystem::path& outer);

}  // namespace keypose
