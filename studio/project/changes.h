// Changes of a project's files, as a person would make them in an editor.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "core/io/text/yaml_edit.h"
#include "pipeline/graph/pipeline_edit.h"
#include "studio/project/snapshot.h"

namespace keypose::studio {

using pipeline::ChangedMeanwhile;
using pipeline::Edited;
using pipeline::WritePipelineFile;

/// What a file of the project holds. @throws InputError  it is not JSON, or nested too deep
nlohmann::json JsonOfFile(const std::filesystem::path& file);

/// The text of pipeline.yaml with a pose's setting. A pose that is only its folder of photographs
/// becomes a map first.
std::string WithPoseSetting(const Snapshot& snapshot, const std::string& text,
                            const std::string& pose, const YamlPath& below,
                            const std::string& value);

/// @throws UsageError  no such pose, or a name that no photograph can have
void RequirePhotograph(Snapshot& snapshot, const std::string& pose, const std::string& name);

struct OptionChange {
  std::string step, option;
  std::string pose;         ///< empty: for all poses
  bool to_default = false;  ///< takes the value out of the file
  std::string value;
};
/// @return the new revision of pipeline.yaml
/// @throws UsageError  no such step, option or pose, or a value that it cannot have
std::string SetOption(Snapshot& snapshot, const OptionChange& change, const std::string& revision);

/// Makes pipeline.yaml and a folder for each pose's photographs.
/// @param few  poses that get few photographs, which the template is fitted to
/// @throws UsageError  a name that cannot be one, twice the same, or there is a project already
void CreateProject(const std::filesystem::path& folder, const std::vector<std::string>& poses,
                   const std::string& template_pose, const std::vector<std::string>& few);

/// What a new performance is made with, beside its shots.
struct FilmedProject {
  std::vector<std::string> shots;
  bool video3d = false;  ///< what moves is painted from the films
  bool surface = false;  ///< what moves is bent into the films
};
/// Makes pipeline.yaml and a folder shots/SHOT for each shot's films.
/// @throws UsageError  as CreateProject
void CreatePerformance(const std::filesystem::path& folder, const FilmedProject& project);
/// One more shot. @throws UsageError  no name, or there is one of it; no performance
void AddShot(const std::filesystem::path& project, const std::string& shot);

}  // namespace keypose::studio
