// A ring model from outlines alone, for figures that show no feature: the cameras in which all
// outlines fit one body.
#pragma once

#include <vector>

#include "core/image.h"
#include "core/progress.h"
#include "reconstruct/turntable/ring_model.h"

namespace keypose::reconstruct {

struct RingSilhouetteOptions {
  int width = 320;  ///< masks are shrunk to about this longer side while searching
  int rays = 24;  ///< of each view's outline while searching; the last adjustment takes three times
                  ///< as many
  double max_error_px = 4;    ///< at the search's size; a worse fit is no fit
  bool adjust_angles = true;  ///< the table's angle at each view too, in the end
};

struct RingSilhouettes {
  bool found = false;
  RingModel model;
  double error_px = 0;  ///< mean distance by which rays of the outlines miss the body, in pixels of
                        ///< the photographs
  std::vector<double> view_error_px;  ///< of each of model.views
  /// where outlines touch the body, in the table's frame; `views` count model.views
  std::vector<SparsePoint> points;
};

/// Fits a ring model to outlines: every line of sight along an outline touches the body, so some
/// point of it lies in all other masks. What the nearest point misses them by, in pixels, is the
/// error; it is zero for true cameras whatever the body. The axis is sought over the whole sphere
/// for each ring, then each ring's turn, height and scale against the first one, by simplex
/// searches; then the table's angles are adjusted in turn.
///
/// @param camera  intrinsics, taken as they are
/// @param masks   of all images, 1 channel, above 127 inside; empty images are left out
/// @return not found when the best error is above the limit, or fewer than 6 views have masks that
/// end within the picture Source: Hernandez, Schmitt & Cipolla, "Silhouette coherence for camera
/// calibration under circular motion", TPAMI 2007.
/// Departs: the error is a distance in pixels and not a share of the outline, so that simplices
/// slide towards the answer from afar.
/// Cost: some thousand evaluations of rays x depths x views; same bits for any thread count.
RingSilhouettes FitRingToSilhouettes(const Camera& camera, const RingLayout& layout,
                                     const std::vector<Image8>& masks,
                                     const RingSilhouetteOptions& options = {},
                                     Progress* progress = nullptr);

}  // namespace keypose::reconstruct
