// Masks of meshes, drawn fast, and masks as a camera's segmentation would give them.
#pragma once

#include <cstdint>

#include "core/values/camera.h"
#include "core/values/image.h"
#include "core/values/mesh.h"

namespace keypose::synth {

/// 255 where a face covers the pixel's centre. Faces with a vertex behind the camera are left out.
Image8 FillMask(const PointsX3& points, const FacesX3& faces, const View& view);

/// The mask with an outline that waves in and out by a normal distribution of `noise_px`, over a
/// length of about six pixels along it.
Image8 NoisyMask(const Image8& mask, double noise_px, std::uint64_t seed);

}  // namespace keypose::synth
