// Colours of the texels that photographs show.
#pragma once

#include <cstdint>
#include <vector>

#include "core/progress.h"
#include "texture/bake/atlas.h"
#include "texture/bake/colour_samples.h"

namespace keypose::texture {

struct PaintResult {
  Painting painting;
  /// one a face: the view that its detail comes from, -1 where none sees it
  std::vector<int> labels;
  std::vector<char> used;        ///< one a view: at least one texel has something of it
  std::int64_t seen_texels = 0;  ///< of those whose centre is in a triangle
  double mean_views = 0;         ///< that see a place of the surface, over the seen part
};

struct PaintOptions {
  double to_mean = 0.03;     ///< how much large-scale colour of the detail is that of all views
                             ///< together; 0: only the borders are levelled
  float detail_step = 0.03;  ///< see PaintTexels; infinite: detail everywhere
};

/// Two pictures in one: the mean of all views that see a place, and the detail of one photograph a
/// face, chosen by a graph cut (labels.h), shifted smoothly in colour (seams.h), and cross-faded
/// over the faces around a border between two. A texel is the detail where the two differ by much
/// less than `detail_step` (square root of linear light), and the mean where by much more.
/// Cost: four colour samples a face and view, one look a texel and view.
/// Same bits for any thread count.
PaintResult PaintTexels(const ColorSampler& sampler, const Atlas& atlas,
                        const PaintOptions& options, Progress* progress);

}  // namespace keypose::texture
