// A ring model from outlines alone, for figures without features: the cameras for which all
// outlines fit one solid.
#pragma once

#include <vector>

#include "core/values/image.h"
#include "core/values/progress.h"
#include "reconstruct/turntable/ring_model.h"

namespace keypose::reconstruct {

struct RingSilhouetteOptions {
  int width = 320;  ///< masks are reduced to about this longer side for the search
  /// per view's outline during the search; the last adjustment uses three times as many
  int rays = 24;
  double max_error_px = 4;    ///< at the search's size; a larger error is no fit
  bool adjust_angles = true;  ///< also adjust the table's angle at each view at the end
};

struct RingSilhouettes {
  bool found = false;
  RingModel model;
  /// mean distance of the outlines' rays from the solid, in pixels of the photographs
  double error_px = 0;
  std::vector<double> view_error_px;  ///< of each of model.views
  /// where outlines touch the solid, in the table's frame; `views` count model.views
  std::vector<SparsePoint> points;
};

/// Fits a ring model to outlines. Every ray through an outline touches the solid, so some point of
/// the ray projects inside all other masks. The error of a ray is the smallest distance of its
/// points outside of those masks, in pixels; it is zero for the true cameras, for any solid. For
/// each ring, simplex searches over the whole sphere find the axis; then each ring's rotation,
/// height and scale relative to the first one; then the table's angles are adjusted in turn.
///
/// @param camera  intrinsics, not changed
/// @param masks   of all images, 1 channel, above 127 inside; empty images are left out
/// @return not found when the best error is above the limit, or fewer than 6 views have masks that
/// end within the picture
/// Source: Hernandez, Schmitt & Cipolla, "Silhouette coherence for camera calibration under
/// circular motion", TPAMI 2007.
/// Departs: the error is a distance in pixels and not a share of the outline, so that simplex
/// searches converge from far starts.
/// Cost: some thousand evaluations of rays x depths x views; same bits for any thread count.
RingSilhouettes FitRingToSilhouettes(const Camera& camera, const RingLayout& layout,
                                     const std::vector<Image8>& masks,
                                     const RingSilhouetteOptions& options = {},
                                     Progress* progress = nullptr);

}  // namespace keypose::reconstruct
