// Checks which existing files and folders a stage may replace with its outputs.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "core/stage/stage.h"

namespace keypose::internal {

/// The paths of each port, by its name.
using PortPaths = std::map<std::string, std::vector<std::filesystem::path>, std::less<>>;

/// Refuses outputs that would remove files of others. An output file may replace a file that is not
/// an input. An output folder may replace an empty folder, or one that this stage wrote and nobody
/// has changed since (MarkFolder). With `overwrite` it may replace any other folder, except the
/// working folder, the home folder, and folders that contain one of these two or an input, or that
/// are part of an input. A file of a port that is `in_place` may replace its input.
/// @param report  file of measurements; empty: none
/// @throws UsageError  two outputs have the same place, or one lies within another
/// @throws DiskError  an output is refused; names the path, the reason and what to do
void CheckOutputs(const StageSpec& spec, const PortPaths& inputs, const PortPaths& outputs,
                  const std::filesystem::path& report, bool overwrite);

/// The same check for one output, without its inputs. It is repeated at the end, because the files
/// may have changed since the stage began.
/// @throws DiskError
void CheckPlace(const StageSpec& spec, const std::filesystem::path& place, bool is_folder,
                bool overwrite);

/// The absolute path of an output. For a folder, links are resolved, so that a link to a folder
/// stays a link.
std::filesystem::path PlaceOf(const std::filesystem::path& given, bool is_folder);

/// Writes a hidden file into a folder that records which stage wrote the folder and which files it
/// has, so that the next run may replace it.
/// @throws DiskError
void MarkFolder(const std::filesystem::path& folder, const std::string& stage);

}  // namespace keypose::internal
