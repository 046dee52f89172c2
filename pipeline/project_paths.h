// Paths as a person writes them in pipeline.yaml and on the command line.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/disk.h"

namespace keypose::pipeline {

/// `~` and `~/...` with the home folder in its place.
/// @throws UsageError  `~name`, or HOME is not set
std::string WithHome(const std::string& path);

/// Where the path that a person wrote lies on disk. A name whose umlauts are spelled otherwise
/// there (macOS takes letters apart, and archives carry that to other systems) is found too. What
/// does not exist comes back as written.
/// @param root  folder that a relative path starts from
/// @return relative to root if `path` is
std::filesystem::path OnDisk(const Disk& disk, const std::filesystem::path& root,
                             const std::filesystem::path& path);

/// The photographs of one pose.
struct PhotoFolder {
  std::string pose;
  std::filesystem::path folder;  ///< absolute, normal
};
/// Why these folders cannot belong to poses of their own: two poses have the same one, or one lies
/// inside another's. Empty: they can.
std::string SharedPhotographs(const std::vector<PhotoFolder>& folders);

}  // namespace keypose::pipeline
