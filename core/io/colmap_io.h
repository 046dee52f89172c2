// COLMAP's model folders (cameras, images, points3D), text and binary.
#pragma once

#include <filesystem>

#include "core/camera.h"

namespace keypose {

/// @param where  file and camera, for the message
/// @throws InputError  a number that is not finite or that no lens has; no pixels, or more than
/// kMostPixels
void RequireUsableCamera(const Camera& camera, const std::string& where);

/// Reads .bin when present, else .txt. Camera models SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL,
/// RADIAL, OPENCV. A missing points3D file gives no points. Views come out sorted by name.
/// @throws InputError  files missing, truncated, or of another camera model
Scene ReadColmapModel(const std::filesystem::path& folder);

/// Writes cameras.bin, images.bin, points3D.bin (OPENCV cameras; equal cameras are written once)
/// that COLMAP reads. Each track names one feature a view, at the projection of its point: COLMAP
/// reads the model, but it holds no original feature.
void WriteColmapModel(const std::filesystem::path& folder, const Scene& scene);

}  // namespace keypose
