// Reads cameras that are known in advance, from a rig, a robot or another program.
#pragma once

#include <filesystem>
#include <vector>

#include "core/values/camera.h"
#include "core/values/lens.h"

namespace keypose {

/// Reads a COLMAP model (colmap_io.h; folder, binary or text), a transforms.json (transforms_io.h),
/// or Metashape's XML (metashape_io.h), by its content or that of its folder. Each lens becomes the
/// camera that maps as it does, to kSameLens_px.
/// @return views sorted by name; width, height, cx, cy are 0 where the file does not give them;
/// focal lengths are negative, in units of the photograph's width, where it gives an angle but no
/// size
/// @throws InputError  of neither kind, damaged, no camera, a repeated name, a matrix that is not a
/// rigid motion, a lens that no Camera maps as; names file, frame and lens model
std::vector<View> ReadPoses(const std::filesystem::path& path);

/// The same with the lenses as they are.
std::vector<LensView> ReadLensPoses(const std::filesystem::path& path);

}  // namespace keypose
