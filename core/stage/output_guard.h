// What a stage may put its outputs in place of, and what it must never remove.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "core/stage/stage.h"

namespace keypose::internal {

/// Where each port's files are, by its name.
using PortPaths = std::map<std::string, std::vector<std::filesystem::path>, std::less<>>;

/// Refuses outputs that would remove what this stage did not write. A file may take the place of a
/// file that is no input. A folder may take the place of an empty one, and of one that this stage
/// wrote and nobody changed since (MarkFolder); with `overwrite` of any other one too, but never of
/// the working folder, the home folder, one that holds or lies around an input, and none that lies
/// within an input. A file of a port that is `in_place` may replace its input.
/// @param report  file of measurements; empty: none
/// @throws UsageError  two outputs have the same place, or one lies within another  @throws
/// DiskError  names the path, why, and what to do
void CheckOutputs(const StageSpec& spec, const PortPaths& inputs, const PortPaths& outputs,
                  const std::filesystem::path& report, bool overwrite);

/// The same for one output alone: what is there now may have changed since the stage began.
/// @throws DiskError
void CheckPlace(const StageSpec& spec, const std::filesystem::path& place, bool is_folder,
                bool overwrite);

/// Where an output lands: absolute, and for a folder with its links resolved, so that a link to a
/// folder stays a link.
std::filesystem::path PlaceOf(const std::filesystem::path& given, bool is_folder);

/// Leaves word in a folder (a hidden file) of which stage wrote it and which files it had, so that
/// the next run may replace it.
/// @throws DiskError
void MarkFolder(const std::filesystem::path& folder, const std::string& stage);

}  // namespace keypose::internal
