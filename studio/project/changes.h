// Changes of a project's files, as a person would make them in an editor.
#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "studio/project/snapshot.h"

namespace keypose::studio {

/// The file was changed by somebody else since the page read it. Nothing was written.
struct ChangedMeanwhile : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// What a file of the project holds. @throws InputError  it is not JSON, or nested too deep
nlohmann::json JsonOfFile(const std::filesystem::path& file);

/// The text that an edit of pipeline.yaml gives. @throws UsageError  it cannot be edited so
std::string Edited(const std::function<std::string()>& edit);

/// pipeline.yaml with another text. Nothing is written if the project could not be used with it.
/// @param revision  of the text that the change was made from
/// @throws ChangedMeanwhile
/// @throws Error  what is wrong with the new text
/// @return the new revision
std::string WritePipelineFile(const std::filesystem::path& project, const std::string& text,
                              const std::string& revision);

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

/// Adds a file to a pose's folder of photographs. Never replaces one with other content.
/// @throws UsageError  no photograph's name, or another photograph of that name is there
void AddPhotograph(Snapshot& snapshot, const std::string& pose, const std::string& name,
                   const std::string& bytes);

/// The mask that a person made for a photograph; empty if there is none.
std::filesystem::path OwnMaskFile(Snapshot& snapshot, const std::string& pose,
                                  const std::string& name);

/// Writes a mask to the pose's folder of masks (masks/POSE if it has none, which then stands in
/// pipeline.yaml). The masks of the other photographs stay computed.
/// @param png  8-bit, of the photograph's size
/// @return the written file
/// @throws UsageError, InputError  no such photograph, not a PNG, of another size
std::filesystem::path SaveMask(Snapshot& snapshot, const std::string& pose, const std::string& name,
                               const std::string& png);

}  // namespace keypose::studio
