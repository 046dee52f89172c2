// The filmed shot of a project: its film, what was found in it, the clicks that help, the result.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "studio/project/snapshot.h"

namespace keypose::studio {

/// All that the page shows, docs/studio-api.md has the fields. Without a `shot` in pipeline.yaml:
/// folders of the project that may be a film.
nlohmann::json ShotJson(Snapshot& snapshot);

/// Writes film, fps and which frames show which pose to pipeline.yaml; settings that stay as they
/// are keep their text, and so does the rest of the file.
/// @param body  {"film", "fps", "shows": [{"frame", "pose"}], "revision"}
/// @throws UsageError  no such pose, a frame twice, a film that is no folder of pictures within the
/// project (unless pipeline.yaml names it already)
/// @throws ChangedMeanwhile
void SaveShot(Snapshot& snapshot, const nlohmann::json& body);

/// Writes the clicks to the file that pipeline.yaml names (clicks.json, which then stands there, if
/// none). Without clicks, the file and its name in pipeline.yaml go.
/// @param body  {"clicks": [...], "revision": of the file}
/// @throws UsageError  a click without pixel or place; a file outside of the project
/// @throws ChangedMeanwhile
void SaveClicks(Snapshot& snapshot, const nlohmann::json& body);

/// A picture of the film, by its number. @throws NotFound
std::filesystem::path FilmFrameFile(Snapshot& snapshot, int frame);

/// @param what    "located" (outlines over the film), "plate" (the empty set as composed),
///                "result" or "compare" (picture `number` of the finished shot)
/// @throws NotFound
std::filesystem::path ShotPictureFile(Snapshot& snapshot, const std::string& what, int number);

}  // namespace keypose::studio
