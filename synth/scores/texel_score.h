// Whether a texel shows the same spot of clay in two poses.
#pragma once

#include "core/values/image.h"
#include "core/values/mesh.h"

namespace keypose::synth {

/// One layout, two poses, compared texel by texel.
struct TexelScore {
  int texels = 0;  ///< compared texels: their centres lie in a face's part of the layout
  /// straight distance, in the rest pose, of the two spots that a texel shows / diagonal of truth_a
  double mean = 0, p95 = 0, max = 0;
  double texel = 0;  ///< mean length of a texel on the surface of pose A / diagonal of truth_a
  double mean_difference = 0;  ///< of the two colours of a texel, mean over channels [0..255]
  /// the difference as PSNR: unchanged, and after one gain per channel; 99 if equal
  double psnr_db = 0, psnr_gain_db = 0;
};

/// The spot that a texel shows is the point of the true surface closest to the texel's place on the
/// pose's mesh. The true surfaces give the correspondence of spots. In textures wider than 512,
/// every (width / 512)-th texel in both directions is used.
///
/// @param truth_a, truth_b  the true surface in both poses: one connectivity
/// @param template_a        with texture coordinates, in the frame of truth_a
/// @param registered_b      the template's vertices in pose B, in the frame of truth_b
/// @param texture_a, texture_b  baked for the two poses, 3 channels, same size
/// @throws InputError  connectivities, sizes or channels differ, there are no texture coordinates,
/// or no texel is covered. Same bits for any thread count.
TexelScore ScoreTexels(const Mesh& truth_a, const Mesh& truth_b, const Mesh& template_a,
                       const PointsX3& registered_b, const Image8& texture_a,
                       const Image8& texture_b);

}  // namespace keypose::synth
