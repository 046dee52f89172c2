// COLMAP's own dense stereo as another backend, where a build with CUDA is installed.
#pragma once

#include <filesystem>

#include "core/stage/stage.h"
#include "core/values/mesh.h"

namespace keypose::reconstruct {

/// Whether the first lines of `colmap -h` name a build that can run patch_match_stereo.
bool BuiltWithCuda(const std::string& help);

/// Undistorts, matches and fuses in the stage's scratch folder.
///
/// @param images    folder of photographs
/// @param model     COLMAP model folder of them
/// @param max_size  longer side of the pictures that are matched [px]
/// @return points with normals and colours in the model's frame; no confidence; masks are not
/// applied
/// @throws ToolError  COLMAP is missing, has no CUDA, or fails
PointCloud RunColmapDense(StageContext& stage, const std::filesystem::path& images,
                          const std::filesystem::path& model, int max_size);

}  // namespace keypose::reconstruct
