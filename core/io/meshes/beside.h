// Files that a mesh names: its materials, textures, data.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace keypose {

/// The file that another one names, in the folder of that or below. Names may be written by Windows
/// (backslashes, drives, other capitals). Of a path that leads elsewhere, or where nothing lies,
/// the file of that name beside is taken.
/// @param owner  the file that names it
/// @return empty: there is none
std::filesystem::path FileBeside(const std::filesystem::path& owner, std::string name);

/// A URI's name: `%20` is a space.
std::string WithoutPercents(std::string_view uri);

}  // namespace keypose
