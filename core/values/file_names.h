// Checks of names that are read from files: a file from an unknown source must not lead outside of
// its folder. Also names in lower case, in which endings are compared.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace keypose {

/// Whether a text is the name of one file or folder: not empty, without '/' and NUL, and neither
/// "." nor "..".
bool IsOneName(std::string_view name);

/// Whether a relative path stays below the folder that it starts from: each part between '/' must
/// pass IsOneName. Links are not followed.
bool StaysBelow(std::string_view path);

/// Whether `inner` is `outer` or lies below it. Compares names only.
/// @pre both paths are normal; links are resolved where they matter
bool IsWithin(const std::filesystem::path& inner, const std::filesystem::path& outer);

/// The letters A to Z become small; other characters stay.
std::string LowerCase(std::string text);
/// The extension of a name in lower case, with the dot: ".jpg" of "IMG_1.JPG".
std::string LowerExtension(const std::filesystem::path& file);

}  // namespace keypose
