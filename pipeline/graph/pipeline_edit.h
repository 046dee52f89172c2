// Changes of a project's pipeline.yaml, as a person would make them in an editor: only the bytes of
// one value change, and never what somebody else wrote meanwhile.
#pragma once

#include <filesystem>
#include <functional>
#include <stdexcept>
#include <string>

#include "core/io/text/yaml_edit.h"
#include "pipeline/graph/pipeline_file.h"

namespace keypose::pipeline {

/// The file was changed by somebody else since it was read. Nothing was written.
struct ChangedMeanwhile : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A hash of a file's bytes, to see whether it has changed; empty for a missing one.
std::string RevisionOf(const std::filesystem::path& file);

/// The text that an edit of pipeline.yaml gives. @throws UsageError  it cannot be edited so
std::string Edited(const std::function<std::string()>& edit);

/// The text of pipeline.yaml with a setting of a pose, or of a performance's shot. One that is only
/// its folder of photographs or films becomes a map first.
/// @param file   what `text` says
/// @param below  the setting's path in the pose's map
/// @param value  YAML in flow style
/// @throws YamlEditError  it cannot be edited so
std::string WithPoseSetting(const PipelineFile& file, const std::string& text,
                            const std::string& pose, const YamlPath& below,
                            const std::string& value);
/// Without it; maps that are empty then go too.
std::string WithoutPoseSetting(const PipelineFile& file, const std::string& text,
                               const std::string& pose, const YamlPath& below);

/// pipeline.yaml with another text. Nothing is written if the project could not be used with it. Of
/// programs of Keypose that write at the same time, one comes after the other.
/// @param revision  of the text that the change was made from
/// @throws ChangedMeanwhile
/// @throws Error  what is wrong with the new text
/// @return the new revision
std::string WritePipelineFile(const std::filesystem::path& project, const std::string& text,
                              const std::string& revision);

}  // namespace keypose::pipeline
