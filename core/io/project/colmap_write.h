// COLMAP's model folders for other programs; colmap_io.h has the one that stages share.
#pragma once

#include <filesystem>

#include "core/values/camera.h"

namespace keypose {

/// Writes cameras, images and points3D as .bin and as .txt with all digits; features are as those
/// of WriteColmapModel. A camera without distortion is a PINHOLE, which trainers of splats take,
/// others are OPENCV. Where a view's name holds a space there is no .txt, as COLMAP's text cannot
/// hold it.
/// @pre the folder exists
/// @throws DiskError
void WriteColmapForOthers(const std::filesystem::path& folder, const Scene& scene);

}  // namespace keypose
