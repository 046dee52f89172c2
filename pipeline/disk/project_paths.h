// Paths as users write them in pipeline.yaml and on the command line.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/disk/disk.h"

namespace keypose::pipeline {

/// Replaces the `~` of `~` and `~/...` by the home folder.
/// @throws UsageError  `~name`, or HOME is not set
std::string WithHome(const std::string& path);

/// Where a user's programs keep what may be lost: keypose below $XDG_CACHE_HOME, else below
/// ~/.cache. Empty if neither is an absolute path. Source: XDG Base Directory Specification.
std::filesystem::path UserCacheFolder();

/// The path on disk for a path that the user wrote. Also finds names whose umlauts are encoded
/// differently on disk (macOS decomposes letters, and archives carry that to other systems). A path
/// that does not exist is returned as written.
/// @param root  folder that a relative path starts from
/// @return relative to `root` if `path` is relative
std::filesystem::path OnDisk(const Disk& disk, const std::filesystem::path& root,
                             const std::filesystem::path& path);

/// The photographs of one pose.
struct PhotoFolder {
  std::string pose;
  std::filesystem::path folder;  ///< absolute, normal
};
/// Why these folders cannot belong to different poses: two poses have the same folder, or one
/// folder lies inside another. Empty if they can.
std::string SharedPhotographs(const std::vector<PhotoFolder>& folders);

}  // namespace keypose::pipeline
