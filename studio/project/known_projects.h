// The projects that a person has opened in the studio, of all folders, for its first page.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace keypose::studio {

/// Where a person's programs keep what they remember: $KEYPOSE_HOME, else keypose below
/// $XDG_STATE_HOME, else below ~/.local/state. Empty if none is known.
std::filesystem::path UserStateFolder();

struct KnownProject {
  std::filesystem::path folder;
  double opened = 0;   ///< [s since 1970]
  bool there = false;  ///< it is a project now
};

/// Whether the folder has a pipeline.yaml, or a puppet's files.
bool IsProject(const std::filesystem::path& folder);

/// The folder that a person has named, without links: a project, or empty, for a new one.
/// @param given  a whole path, of the folder or its pipeline.yaml
/// @throws UsageError  it is neither; says which folder within it is a project, if one is
std::filesystem::path FolderToOpen(const std::string& given);

/// The latest first. A file that cannot be read counts as none.
/// @param state  the folder of UserStateFolder
std::vector<KnownProject> KnownProjects(const std::filesystem::path& state);

/// Puts a project first. Keeps the latest 50. What cannot be written is not remembered.
void Remember(const std::filesystem::path& state, const std::filesystem::path& folder, double now);
/// Takes it from the list; its folder stays.
void ForgetProject(const std::filesystem::path& state, const std::filesystem::path& folder);

/// A new folder for a project of this name: in `base`, and not there yet or empty.
/// @throws UsageError  the name is no name of a folder, or the folder has files
std::filesystem::path NewProjectFolder(const std::filesystem::path& base, const std::string& name);

}  // namespace keypose::studio
