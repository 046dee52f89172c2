// What a filmed shot consists of: film, plates, mattes, props, and whether the camera moves.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "studio/project/snapshot.h"

namespace keypose::studio {

/// What of the project may be a part of a filmed shot, its own making left out: "folders" of
/// numbered pictures ({"path", "pictures"}), paths of "videos", single "pictures" and "meshes".
nlohmann::json ShotOffersJson(Snapshot& snapshot);

/// "still" or "moving", as the step `locate` takes it.
std::string ShotCamera(Snapshot& snapshot);

/// Writes what the shot consists of to pipeline.yaml; settings that stay as they are keep their
/// text, and so does the rest of the file.
/// @param body  {"film", "fps", "shows": [{"frame", "pose"}], "revision"}, and what else is to
/// change of "plate", "mattes", "holdout", "set" (a path; "" takes it out) and "camera" ("still",
/// "moving")
/// @throws UsageError  no such pose, a frame twice; a path that is not of that kind, or not within
/// the project (unless pipeline.yaml has it already); a single plate for a moving camera
/// @throws ChangedMeanwhile
void SaveShot(Snapshot& snapshot, const nlohmann::json& body);

}  // namespace keypose::studio
