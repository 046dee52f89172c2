// Reads and writes COLMAP's model folders (cameras, images, points3D). Reads text and binary.
#pragma once

#include <filesystem>
#include <vector>

#include "core/values/camera.h"
#include "core/values/lens.h"

namespace keypose {

/// Reads .bin when present, else .txt, of the folder or of the one model below it (`sparse/0`,
/// `sparse`, `0`). Every lens model of COLMAP is read by name (colmap_lens.h), and becomes the
/// camera that maps as it does. rigs, frames and other files beside are not needed: images hold
/// their own places. Text may have empty lines, comments, carriage returns, names with spaces, and
/// images without their line of features. A missing points3D file gives no points. The views are
/// sorted by name.
/// @throws InputError  files missing, truncated, several models below; a lens that no Camera maps
/// as: names the model
Scene ReadColmapModel(const std::filesystem::path& folder);

/// The views of the same, with their lenses as they are.
/// @throws InputError  as above, but for the lenses: EQUIRECTANGULAR, and numbers of newer models
std::vector<LensView> ReadColmapLenses(const std::filesystem::path& folder);

/// Whether the folder is a model, or has one below it where ReadColmapModel looks.
bool HasColmapModel(const std::filesystem::path& folder);

/// Writes cameras.bin, images.bin and points3D.bin, with OPENCV cameras; equal cameras are written
/// once. COLMAP can read the model, but the features in it are not the original ones: each track
/// has one feature in each of its views, at the projection of the point.
void WriteColmapModel(const std::filesystem::path& folder, const Scene& scene);

}  // namespace keypose
