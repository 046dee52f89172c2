// How well a textured mesh repeats the photographs that it was baked from.
#pragma once

#include "core/image.h"
#include "core/mesh.h"
#include "core/ray_scene.h"
#include "texture/bake_view.h"

namespace keypose::texture {

/// Squared 8-bit sRGB differences between a view's photograph and the mesh rendered into it without lamps, where the view has full trust.
struct Comparison {
  int pixels = 0;
  double psnr_db = 0;       ///< as the photograph is
  double psnr_gain_db = 0;  ///< rendering divided by `gain` (linear light) first
};
Comparison CompareToPhotograph(const Mesh& mesh, const RayScene& scene, const Image8& texture, const BakeView& view,
                               const Eigen::Vector3f& gain);

/// 10 log10(255^2 / mean square), at most 99 (no difference at all).
double Psnr(double sum_of_squares, double count);

}  // namespace keypose::texture
