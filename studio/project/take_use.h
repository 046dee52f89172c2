// The baked frames of a recorded take as a part of the project: a step of pipeline.yaml that
// exports them, and one that puts them over their plate. The file is made if there is none.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace keypose::studio {

/// Files are named from the project's folder; empty ones are not there.
struct BakedTake {
  std::string name;
  std::string texture, plate, shot, set;
};

/// {"revision", "baked": frames are there, "stale": but the take has changed since, "uses": {NAME:
/// {"step", "out", "used", "lack": what is missing for it, or ""}, ...}}, NAME is "export" or
/// "composite".
/// @throws UsageError  pipeline.yaml cannot be read
nlohmann::json TakeUseJson(const std::filesystem::path& project, const BakedTake& take);

/// Writes the step of that use to pipeline.yaml, or takes it and its options out again. All else
/// keeps its text.
/// @param use  "export" or "composite"
/// @throws UsageError  no such use, frames are not baked, something is missing
/// @throws ChangedMeanwhile
void SaveTakeUse(const std::filesystem::path& project, const BakedTake& take,
                 const std::string& use, bool used, const std::string& revision);

}  // namespace keypose::studio
