// Reads and writes COLMAP's model folders (cameras, images, points3D). Reads text and binary.
#pragma once

#include <filesystem>

#include "core/values/camera.h"

namespace keypose {

/// @param where  file and camera, for the message
/// @throws InputError  a parameter that is not finite or not possible for a lens; no pixels, or
/// more than kMostPixels
void RequireUsableCamera(const Camera& camera, const std::string& where);

/// Reads .bin when present, else .txt. Knows the camera models SIMPLE_PINHOLE, PINHOLE,
/// SIMPLE_RADIAL, RADIAL and OPENCV. A missing points3D file gives no points. The views are sorted
/// by name.
/// @throws InputError  files missing, truncated, or of another camera model
Scene ReadColmapModel(const std::filesystem::path& folder);

/// Writes cameras.bin, images.bin and points3D.bin, with OPENCV cameras; equal cameras are written
/// once. COLMAP can read the model, but the features in it are not the original ones: each track
/// has one feature in each of its views, at the projection of the point.
void WriteColmapModel(const std::filesystem::path& folder, const Scene& scene);

}  // namespace keypose
