// Colours of the texels that photographs show.
#pragma once

#include <cstdint>
#include <vector>

#include "core/values/progress.h"
#include "texture/bake/colour_samples.h"
#include "views/atlas/atlas.h"

namespace keypose::texture {

struct PaintResult {
  Painting painting;
  /// one per face: the view that its detail comes from, -1 where none sees it
  std::vector<int> labels;
  std::vector<char> used;        ///< one per view: whether it contributed to any texel
  std::int64_t seen_texels = 0;  ///< of those with their centre in a triangle
  double mean_views = 0;         ///< number of views that see a point, over the seen part
};

struct PaintOptions {
  double to_mean = 0.03;  ///< weight of all views' mean in the large-scale colour of the detail; 0:
                          ///< only the borders are levelled
  float detail_step = 0.03;  ///< see PaintTexels; infinite: detail everywhere
};

/// Combines two pictures: the mean of all views, and the detail of one photograph per face. That
/// photograph is chosen by a graph cut (labels.h), shifted smoothly in colour (seam_levelling.h),
/// and cross-faded over the faces around a border between two. A texel has the detail where the two
/// pictures differ by much less than `detail_step` (square root of linear light), and the mean
/// where they differ by much more.
/// Cost: four colour samples per face and view, one evaluation per texel and view.
/// Same bits for any thread count.
PaintResult PaintTexels(const ColorSampler& sampler, const Atlas& atlas,
                        const PaintOptions& options, Progress* progress);

}  // namespace keypose::texture
