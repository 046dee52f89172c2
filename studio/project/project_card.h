// What the studio's first page shows of a project that is not open: a picture, and how far it is.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>

namespace keypose::studio {

/// {"state", "done", "steps", "poses", "kind", "problem"}: `done` of `steps` steps are up to date.
/// state: "running" (a run is at work, whoever has started it), "done", "failed", "begun", "new",
/// "empty" (no pipeline.yaml), or "broken" with the problem in words. Never throws for a folder
/// that is there.
nlohmann::json ProjectCardJson(const std::filesystem::path& folder);

/// A picture of what the project makes, else of what it is made from: a small JPEG or PNG, kept in
/// the project. @throws NotFound  there is none yet
std::filesystem::path ProjectPicture(const std::filesystem::path& folder);

}  // namespace keypose::studio
