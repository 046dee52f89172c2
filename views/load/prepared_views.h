// From folders of photographs, masks and cameras to prepared views, for the stages that compare
// photographs.
#pragma once

#include <string>
#include <vector>

#include "core/camera.h"
#include "core/stage/stage.h"
#include "views/prepared/prepared_view.h"

namespace keypose {

/// The photographs of the stage's port `images` that the scene names, made ready. Views whose mask
/// is empty, and photographs that contradict the others (`trusted` in capture.json), are left out
/// with a note.
///
/// @param stage_name  begins the messages
/// @param max_size    longer side of the largest prepared picture [px]
/// @throws InputError  no views, photographs or masks that are missing, or fewer than 3 masks with
/// anything in them; names them
std::vector<PreparedView> LoadPreparedViews(StageContext& stage, const std::string& stage_name,
                                            const Scene& scene, int max_size, int levels);

}  // namespace keypose
