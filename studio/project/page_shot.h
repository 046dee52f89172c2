// The filmed shot of a project as the page shows it: its film, what was found in it, the result.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "studio/project/snapshot.h"

namespace keypose::studio {

/// All that the page shows, docs/studio-api.md has the fields. Also what of the project may become
/// a part of the shot.
nlohmann::json ShotJson(Snapshot& snapshot);

/// A picture of the film, by its number. @throws NotFound
std::filesystem::path FilmFrameFile(Snapshot& snapshot, int frame);

/// @param what    "located" (outlines over the film), "quick" (over one frame, of the answer
///                `number` of shot_clicks.h), "plate" (the empty set as composed),
///                "result" or "compare" (picture `number` of the finished shot)
/// @throws NotFound
std::filesystem::path ShotPictureFile(Snapshot& snapshot, const std::string& what, int number);

}  // namespace keypose::studio
