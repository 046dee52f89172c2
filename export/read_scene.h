// Reads the frames, textures and notes of an animation from files.
#pragma once

#include <string>
#include <vector>

#include "core/stage/stage.h"
#include "export/animation/scene.h"

namespace keypose::exporting {

/// The share of the stage's time, for progress, after which all is read.
inline constexpr double kReadingShare = 0.1;

/// How the frames lie in space.
struct FramePlacement {
  bool z_up = true;      ///< else y is
  double metres = 1;     ///< of a unit of the frames
  double front_deg = 0;  ///< where the figure looks, counter-clockwise seen from above, from -y (z
                         ///< up) or z (y up); it is turned to look there
};

/// Reads the stage's inputs `frames`, `textures`, `layout` and `polygons`. Warns if textures cannot
/// be blended because they do not belong to the frames' keys.
///
/// @param poses     names of the keys' poses, one per texture; may be empty
/// A folder as the only texture has one for each frame.
/// @throws UsageError  the number of names is not that of the textures
/// @throws InputError  no frames, a missing number of a frame or of a texture, frames of different
/// connectivity, an unreadable texture or distortion.json
Scene ReadScene(StageContext& stage, const PlaybackOptions& playback,
                const FramePlacement& placement, const std::vector<std::string>& poses);

}  // namespace keypose::exporting
