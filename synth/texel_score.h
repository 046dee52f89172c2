// Whether a texel shows the same spot of clay in two poses.
#pragma once

#include "core/image.h"
#include "core/mesh.h"

namespace keypose::synth {

/// One layout, two poses, compared texel by texel.
struct TexelScore {
  int texels = 0;  ///< compared: their centres lie in a face's part of the layout
  double mean = 0, p95 = 0, max = 0;  ///< straight distance, on the rest clay, of the two spots
                                      ///< that a texel shows, over truth_a's diagonal
  double texel = 0;            ///< mean length of a texel on the clay of pose A, over the same
  double mean_difference = 0;  ///< of the texel's two colours, mean of channels [0..255]
  double psnr_db = 0, psnr_gain_db = 0;  ///< the same as a peak ratio, as it is and after one gain
                                         ///< a channel for the light; 99 when equal
};

/// The spot that a texel shows is the point of the true surface that is nearest to the texel's
/// place on the pose's mesh; the true surfaces say which spots are the same. Of textures wider than
/// 512 every (width / 512)-th texel in both directions is taken.
///
/// @param truth_a, truth_b  the true surface in both poses: one connectivity
/// @param template_a        with texture coordinates, in the frame of truth_a
/// @param registered_b      the template's vertices in pose B, in the frame of truth_b
/// @param texture_a, texture_b  baked of both poses, 3 channels, the same size
/// @throws InputError  connectivities, sizes or channels differ, no texture coordinates, or no
/// texel is covered Same bits for any thread count.
TexelScore ScoreTexels(const Mesh& truth_a, const Mesh& truth_b, const Mesh& template_a,
                       const PointsX3& registered_b, const Image8& texture_a,
                       const Image8& texture_b);

}  // namespace keypose::synth
