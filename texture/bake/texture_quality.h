// How well a rendered textured mesh matches photographs.
#pragma once

#include <vector>

#include "core/pictures/image_quality.h"
#include "core/surfaces/ray_scene.h"
#include "core/values/image.h"
#include "core/values/mesh.h"
#include "texture/bake/bake_view.h"

namespace keypose::texture {

/// A texture with its mipmap levels, so that distant texels are averaged, not skipped.
class TextureLevels {
 public:
  explicit TextureLevels(Image8 texture);
  /// sRGB, 0..255, averaged over about `texels` texels in each direction.
  Eigen::Vector3d Sample(const Eigen::Vector2d& uv, double texels) const;

 private:
  std::vector<Image8> levels_;
};

/// Comparison of one photograph with the mesh rendered into it without lights, over the pixels
/// inside the mask that the mesh covers, except within the guard of edges of depth and mask. 8-bit
/// sRGB.
struct Comparison {
  int pixels = 0;
  double psnr_db = 0;  ///< of the unchanged pictures
  /// after one factor per channel (linear light) that gives the rendering the photograph's mean
  double psnr_gain_db = 0;
  double ssim = 0;  ///< of the luma of the unchanged pictures (core/pictures/image_quality.h)
};
/// At most 200,000 rays.
/// @param texture_size  of `texture`, for the footprint of a ray
Comparison CompareToPhotograph(const Mesh& mesh, const TextureLevels& texture, int texture_size,
                               const BakeView& view);

}  // namespace keypose::texture
