// Files of the installation that programs read besides their inputs, such as a network's weights.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace keypose {

/// A file of share/keypose beside the program's folder: in a build folder as under a prefix. The
/// environment variable KEYPOSE_<NAME> (upper case, other characters as '_'), when it is set, is
/// its path instead.
/// @return none: there is no such file
std::optional<std::filesystem::path> FindSharedFile(const std::string& name);

/// What a fingerprint takes for the file's version: the first word of NAME.sha256 beside it.
/// "not installed" when either file is missing.
std::string SharedFileVersion(const std::string& name);

}  // namespace keypose
