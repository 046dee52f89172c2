// Reads photographs, masks and cameras from folders and makes prepared views, for the stages that
// compare photographs.
#pragma once

#include <string>
#include <vector>

#include "core/stage/stage.h"
#include "core/values/camera.h"
#include "views/prepared/prepared_view.h"

namespace keypose {

/// Prepares the photographs of the stage's port `images` that the scene names. Views with an empty
/// mask, and photographs that disagree with the others (`trusted` in capture.json), are left out
/// with a note.
///
/// @param stage_name  prefix of the messages
/// @param max_size    longer side of the prepared pictures; smaller photographs stay as they are
/// [px]
/// @param fewest        views that are needed
/// @throws InputError  no views, missing photographs or masks, or fewer than `fewest` masks that
/// are not empty; names them
std::vector<PreparedView> LoadPreparedViews(StageContext& stage, const std::string& stage_name,
                                            const Scene& scene, int max_size, int levels,
                                            int fewest = 3);

}  // namespace keypose
