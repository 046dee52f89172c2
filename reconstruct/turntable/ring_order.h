// The order in which photographs of a turntable were shot, found from what they show: for names
// that do not tell it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/camera.h"
#include "core/progress.h"
#include "reconstruct/turntable/ring_model.h"
#include "reconstruct/turntable/ring_start.h"

namespace keypose::reconstruct {

struct RingOrderOptions {
  double max_error_px = 4;  ///< of a match from its epipolar line
  /// of the object's radius: how far from a known point a match may lie
  double near_surface = 0.1;
  double min_score = 4;      ///< matches that hold a photograph in its place, nearly
  double first_clear = 1.2;  ///< by how many standard deviations of such counts the first place
                             ///< found must stand out from any other,
  double least_clear = 0.5;  ///< and those after it, for which the ring model of all has to answer
  /// of a step, rms: places farther off even steps are no even steps
  double max_uneven_share = 0.2;
};

struct RingOrder {
  RingLayout layout;  ///< of the photographs that found a place; steps and gaps as found
  int sorted = 0;     ///< photographs in the layout
  /// places fall on even steps of the table; else `layout` counts in parts of a step
  bool even = true;
  std::vector<int> left_out;  ///< images without a place
};

/// Sorts photographs along the rings that a part of them forms. The cameras of the part tell the
/// table's axis and the rings, so that each other photograph has but one unknown, its place on a
/// ring; or two, where it belongs to a ring of which the part has none: the place and the
/// elevation, at the same distance and with the same aim. All raw matches with photographs that
/// have a place decide, by truncated epipolar errors and whether the lines of sight meet near the
/// object. The clearest photograph is placed first and helps to place the rest.
///
/// @param part    cameras and points of some of the photographs, in any frame
/// @param names   of all images
/// @param pairs   raw matches of pairs of images, however few and wrong
/// @return nothing when the part's cameras form no ring about one axis, or no other photograph
/// finds a place Same bits for any thread count.
std::optional<RingOrder> OrderOnRings(const Scene& part, const std::vector<std::string>& names,
                                      const std::vector<PairPoints>& pairs,
                                      const RingOrderOptions& options = {},
                                      Progress* progress = nullptr);

}  // namespace keypose::reconstruct
