// Colours of the texels that photographs show.
#pragma once

#include <cstdint>
#include <vector>

#include "core/progress.h"
#include "texture/bake_atlas.h"
#include "texture/bake_votes.h"

namespace keypose::texture {

struct PaintResult {
  Painting painting;
  std::vector<int> labels;       ///< one a face: the view that its detail comes from, -1 where none sees it
  std::vector<char> used;        ///< one a view: the detail of at least one texel comes from it
  std::int64_t seen_texels = 0;  ///< of those whose centre is in a triangle
  double mean_views = 0;         ///< that see a place of the surface, over the seen part
};

/// Each face from one photograph, chosen by a graph cut (bake_labels.h) and shifted smoothly in colour (bake_seams.h). Where the choice
/// changes both are cross-faded over the faces around the border. What the chosen view does not see of a face comes from the next best.
/// Cost: four votes a face, and little more than one sample a texel. Same bits for any thread count.
///
/// @param to_mean  how much large-scale colour is that of all views together; 0: only the borders are levelled
PaintResult PaintTexels(const Witnesses& witnesses, const Atlas& atlas, double to_mean, Progress* progress);

}  // namespace keypose::texture
