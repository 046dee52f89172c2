// Which COLMAP is installed, and how it names its options: they moved between 3.8 and 4.1.
#pragma once

#include <string>
#include <vector>

namespace keypose::reconstruct {

/// A release of COLMAP.
struct ColmapRelease {
  int major = 3, minor = 8;
  auto operator<=>(const ColmapRelease&) const = default;
};

/// The latest release whose options are known here.
inline constexpr ColmapRelease kLatestKnownColmap{4, 1};

/// The release in the first line of COLMAP's help, as in "COLMAP 4.1.0 -- Structure-from-Motion
/// ...".
/// @throws ToolError  no release in it, or one before 3.7
ColmapRelease ParseColmapRelease(const std::string& line);

/// Arguments as that release takes them.
/// @param arguments  with the names of 3.8; those that do not begin with -- stay as they are
/// Source: option_manager.cc of the releases 3.8 to 4.1.1.
std::vector<std::string> ArgumentsFor(const ColmapRelease& release,
                                      std::vector<std::string> arguments);

}  // namespace keypose::reconstruct
