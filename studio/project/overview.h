// What the page shows of a project and its steps, as JSON. docs/studio-api.md has the fields.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "studio/project/snapshot.h"

namespace keypose::studio {

/// A project without a pipeline.yaml: the page offers to make one.
nlohmann::json EmptyProjectJson(const std::filesystem::path& folder);
/// A project whose pipeline.yaml cannot be used: only its name, and what is wrong.
nlohmann::json BrokenProjectJson(const std::filesystem::path& folder, const std::string& problem);
nlohmann::json ProjectJson(Snapshot& snapshot);

/// @param running    whether a run is at work that the studio follows
/// @param locked_by  words on who else holds the project's lock
nlohmann::json StepsJson(Snapshot& snapshot, bool running, const std::string& locked_by);
nlohmann::json NoStepsJson(bool running, const std::string& locked_by);
/// @param describe  a stage program's --describe text
nlohmann::json StageJson(const std::string& describe);
/// The step's last log, at most its last megabyte.
/// @throws UsageError  no such step
std::string LogText(Snapshot& snapshot, const std::string& step);

/// The files below out/ that a person takes away.
nlohmann::json ResultsJson(Snapshot& snapshot);

}  // namespace keypose::studio
