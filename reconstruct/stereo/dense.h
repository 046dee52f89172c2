// Dense multi-view stereo from prepared photographs: hull, bounds, source views, PatchMatch,
// fusion.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/values/camera.h"
#include "core/values/mesh.h"
#include "core/values/options.h"
#include "core/values/progress.h"
#include "views/hull/silhouettes.h"
#include "views/prepared/prepared_view.h"

namespace keypose::reconstruct {

struct DenseOptions {
  std::string backend = "patchmatch";
  int max_size = 1600;
  int levels = 3;
  int sources = 8;
  int geometric_passes = 2;
  int least_views = 3;
  double reprojection_px = 1.5;
  double depth_tolerance = 0.01;
  double normal_tolerance_deg = 30;
  double largest_cost = 1.0;
  double largest_error = 1.0;
  double narrow_texture = 4;
  double window_variance = 16;
  int hull_resolution = 160;
  double outline_px = 1.5;
  bool frontier_points = true;
  bool gap_fill = true;
  bool hull_fill = true;
  void Describe(OptionVisitor& visit);
};

struct DenseResult {
  PointCloud cloud;         ///< world frame; normals towards the cameras, colour, confidence
  int stereo_points = 0;    ///< the first points of the cloud
  int gap_points = 0;       ///< the next ones, fitted over gaps; then come the hull's
  int frontier_points = 0;  ///< the last ones, where rays through masks' borders touch the surface
  int contradicted_points = 0;       ///< dropped because they are inconsistent with frontier points
  std::vector<double> completeness;  ///< for each view, share of masked pixels with a fused depth
  std::vector<std::string> views_without_sources;
  HullCheck hull_check;          ///< each mask against the visual hull of all masks
  int outside_points = 0;        ///< dropped because they lie outside of the masks
  std::int64_t evaluations = 0;  ///< number of window correlations
  double hull_volume = 0;
  double matching_cpu_seconds = 0;  ///< of PatchMatch alone, all threads together
};

/// The stage's entire computation.
///
/// @param views  with at least one masked pixel each, all with options.levels levels, in the order
/// of their names
/// @param scene  the target of the views' scene_index; its sparse points are used if there are any
/// @throws InputError  fewer than 3 views, masks without common space, no view with two or more
/// sources, or no consistent depths; names the views
/// Same bits for any thread count on one kind of processor.
DenseResult ReconstructDense(const std::vector<PreparedView>& views, const Scene& scene,
                             const DenseOptions& options, Progress* progress = nullptr);

}  // namespace keypose::reconstruct
