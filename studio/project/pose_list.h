// The poses of a project, as a person orders them: added, renamed, sorted, one chosen as template.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "studio/project/snapshot.h"

namespace keypose::studio {

/// Writes pipeline.yaml; if the project cannot be opened with it, the old text is back, and the
/// reason is thrown.
/// @throws ChangedMeanwhile, Error
void WriteCheckedPipeline(const std::filesystem::path& project, const std::string& before,
                          const std::string& text, const std::string& revision);

/// Files and folders that are a pose's alone and in the project, relative to it: its photographs,
/// its landmarks and masks.
std::vector<std::filesystem::path> FilesOfPose(Snapshot& snapshot, const std::string& pose);

/// @param few  it gets few photographs, which the template is bent into
/// @throws UsageError  a name that cannot be one, or is taken
void AddPose(Snapshot& snapshot, const std::string& pose, bool few);

/// Renames a pose in pipeline.yaml, and its photographs, landmarks and masks where they are named
/// after it. All of it, or nothing.
/// @throws UsageError  as above
void RenamePose(Snapshot& snapshot, const std::string& pose, const std::string& name);

/// @param order  all poses
void OrderPoses(Snapshot& snapshot, const std::vector<std::string>& order);

/// @throws UsageError  a pose of few photographs, which has no scan
void ChooseTemplate(Snapshot& snapshot, const std::string& pose);

/// Whether the template is bent into the pose's few photographs, or it is scanned.
/// @throws UsageError  the template is asked to be bent
void ChooseMethod(Snapshot& snapshot, const std::string& pose, bool few);

/// The text of pipeline.yaml with a pose out of the bin.
/// @param what  its deleted.json
/// @throws YamlEditError, UsageError
std::string WithPoseBack(const std::string& text, const std::string& pose,
                         const nlohmann::json& what);

}  // namespace keypose::studio
