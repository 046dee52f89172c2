// Estimates the shooting order of turntable photographs from their content, for names that do not
// give it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/values/camera.h"
#include "core/values/progress.h"
#include "reconstruct/turntable/ring_model.h"
#include "reconstruct/turntable/ring_start.h"

namespace keypose::reconstruct {

struct RingOrderOptions {
  double max_error_px = 4;  ///< of a match from its epipolar line
  /// largest distance of a match from a known point, over the object's radius
  double near_surface = 0.1;
  /// least score of a position: about the number of matches consistent with it
  double min_score = 4;
  double first_clear = 1.2;  ///< the first position must exceed any other by this many standard
                             ///< deviations of such counts
  double least_clear = 0.5;  ///< the same for later positions, which the final ring model checks
  /// of a step, rms: with larger deviations positions are not evenly spaced
  double max_uneven_share = 0.2;
};

struct RingOrder {
  RingLayout layout;  ///< of the photographs with a position; steps and gaps as estimated
  int sorted = 0;     ///< photographs in the layout
  /// positions fall on even steps of the table; else `layout` counts in parts of a step
  bool even = true;
  std::vector<int> left_out;  ///< images without a position
};

/// Assigns positions to photographs on the rings that some of the photographs form. The known
/// cameras define the table's axis and the rings, so each other photograph has one unknown, its
/// position on a ring. If it belongs to a new ring it has two: position and elevation, at the same
/// distance and with the same aim. All raw matches with photographs that have a position are used,
/// with truncated epipolar errors and the condition that rays intersect near the object. The
/// photograph with the clearest position is placed first, and then helps to place the others.
///
/// @param part    cameras and points of some of the photographs, in any frame
/// @param names   of all images
/// @param pairs   raw matches of pairs of images, also few and wrong ones
/// @return nothing if the known cameras form no ring about one axis, or no other photograph gets a
/// position
/// Same bits for any thread count.
std::optional<RingOrder> OrderOnRings(const Scene& part, const std::vector<std::string>& names,
                                      const std::vector<PairPoints>& pairs,
                                      const RingOrderOptions& options = {},
                                      Progress* progress = nullptr);

}  // namespace keypose::reconstruct
