// How well a textured mesh repeats photographs.
#pragma once

#include <vector>

#include "core/image.h"
#include "core/image_quality.h"
#include "core/mesh.h"
#include "core/ray_scene.h"
#include "texture/bake/bake_view.h"

namespace keypose::texture {

/// A texture and its halves, quarters, ...: far texels are averaged, not skipped.
class TextureLevels {
 public:
  explicit TextureLevels(Image8 texture);
  /// sRGB, 0..255, of about `texels` texels each way.
  Eigen::Vector3d Sample(const Eigen::Vector2d& uv, double texels) const;

 private:
  std::vector<Image8> levels_;
};

/// One photograph against the mesh rendered into it without lamps, over the pixels inside the mask
/// that the mesh covers, except within the guard of edges of depth and mask. 8-bit sRGB.
struct Comparison {
  int pixels = 0;
  double psnr_db = 0;  ///< as both are
  /// after one factor a channel (linear light) that gives the render the photograph's mean
  double psnr_gain_db = 0;
  double ssim = 0;  ///< of the luma as both are (core/image_quality.h)
};
/// At most 200,000 rays.
/// @param texture_size  of `texture`, for the footprint of a ray
Comparison CompareToPhotograph(const Mesh& mesh, const TextureLevels& texture, int texture_size,
                               const BakeView& view);

}  // namespace keypose::texture
