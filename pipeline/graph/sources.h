// Finds what a project gives by the words of the table `sources`.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/disk/disk.h"
#include "pipeline/graph/pipeline_file.h"

namespace keypose::pipeline {

/// The folder of a pose's photographs, as written in pipeline.yaml. For those who read a project's
/// file alone, without the table: `init` and the default table say the same.
std::string PhotographsOf(const PoseRule& pose);
/// The folder of a shot's films, as PhotographsOf.
std::string VideoOf(const PoseRule& shot);

/// Checks the table, and that all keys of poses, shots and the project that could be its words are.
/// @param file  the project's over the default one
/// @throws UsageError  a word twice, a default with an unknown {word}, a key that is not in the
/// table (names the nearest), or a value that is no path; with file:line
void CheckSources(const PipelineFile& file);

class Sources {
 public:
  /// @param file  checked; kept by reference, as is `disk`
  /// @param template_pose  empty where there is no pose
  Sources(const PipelineFile& file, const Disk& disk, std::filesystem::path project,
          const std::string& template_pose);

  /// @param word  without the $
  /// @return null: it is not in the table
  const SourceRule* Find(const std::string& word) const;
  /// All words, with the $: those of the table and $unmasked.
  std::vector<std::string> Words() const;
  /// Whether a step needs a pose to take it.
  bool IsOfPose(const std::string& word) const;
  /// Whether `Find` or the runner itself knows the word.
  bool Knows(const std::string& word) const;

  /// The path that is named, or else a default.
  /// @param pose  may be null for what is not of a pose
  std::optional<Setting> PathOf(const SourceRule& rule, const PoseRule* pose) const;
  /// As PathOf; of a pair the template's path, then the pose's. Empty where one is missing.
  std::vector<Setting> PathsOf(const SourceRule& rule, const PoseRule* pose) const;
  /// The poses whose paths PathsOf gives: the one, or of a pair the template and then the pose.
  std::vector<const PoseRule*> PosesOf(const SourceRule& rule, const PoseRule* pose) const;
  /// Whether the word gives anything.
  bool Gives(const std::string& word, const PoseRule* pose) const;
  /// Whether there is no folder `masks` beside the shot's films.
  bool IsUnmasked(const PoseRule& shot) const;

  /// A default or a message of the rule with {pose}, {shot} and earlier words filled in. Nothing
  /// where one of these words gives nothing.
  std::optional<std::string> Filled(const std::string& text, const SourceRule& rule,
                                    const PoseRule* pose) const;
  /// The path on disk, from the project on.
  std::filesystem::path Located(const Setting& path) const;
  bool IsThere(const Setting& path) const;
  std::vector<std::string> Children(const std::filesystem::path& folder) const;

 private:
  std::optional<Setting> DefaultOf(const SourceRule& rule, const PoseRule* pose) const;
  std::optional<Setting> WithAnyEnding(const Setting& pattern) const;

  const PipelineFile& file_;
  const Disk& disk_;
  std::filesystem::path project_;
  const PoseRule* template_;
};

}  // namespace keypose::pipeline
