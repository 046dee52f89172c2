// Bends a template until it agrees with calibrated views.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/values/camera.h"
#include "core/values/image.h"
#include "core/values/mesh.h"
#include "core/values/progress.h"
#include "fit/bending/bend_input.h"
#include "fit/bending/pick_constraints.h"

namespace keypose::fit {

/// How well one view agrees with the result.
struct ViewQuality {
  int matches = 0;            ///< features used
  double outline_gap_px = 0;  ///< mean distance between silhouette and mask, both ways
  double correlation = 0;     ///< mean over the patches that were found
  double overlap = 0;         ///< of silhouette and mask, intersection over union
};

struct BendResult {
  PointsX3 points;              ///< V x 3, of the template's vertices
  std::vector<Rigid3> cameras;  ///< camera from world, one a view
  Eigen::VectorXi views;        ///< V: how many views hold the vertex by texture
  Eigen::VectorXd confidence;   ///< V, 0 to 1: how firmly the views hold the vertex
  std::vector<ViewQuality> view_quality;
  std::vector<PickQuality> marks;  ///< of the marks' pixels, then of their places
  int limbs_turned = 0;            ///< that stood wrongly after the far rounds
  int unfolded = 0;                ///< vertices moved because a face beside them was flipped
  int flipped = 0;                 ///< faces that could not be turned back so
  double volume_ratio = 1;         ///< over the template's
};

/// Coarse to fine. First the features alone bend a coarse level with a robust weight, so that
/// limbs find far places; then outlines join (from the silhouette to the mask and back, which
/// prevents shrinking). Limbs that the photographs still contradict are then looked for in other
/// turns. At last grey values of patches around every vertex. The shape is as rigid as
/// possible throughout, so what no view shows follows its neighbours rigidly. Picks pull
/// strongly in the far rounds, and weakly beside grey values. A mark that is still far off after
/// the far rounds is refused, and these begin again without it.
///
/// @param mesh       the template in the world's frame, near the figure; closed, with UVs (if it
///                   has a texture)
/// @param texture    RGB; empty: outlines and marks alone, and no vertex is held by texture
/// @param stiffness  V, or empty
/// @param marks      what a person picked; may be empty
/// @throws InputError   no views; unusable mesh
/// @throws SolverError  @throws Cancelled
/// Same bits for any thread count.
/// See docs/algorithms/fit.md.
BendResult BendToViews(const Mesh& mesh, const Image8& texture, const Eigen::VectorXd& stiffness,
                       const std::vector<BendView>& views, const BendPicks& marks,
                       const BendOptions& options, Progress* progress = nullptr);

}  // namespace keypose::fit
