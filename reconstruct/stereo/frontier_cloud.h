// Frontier points in a cloud: adds points where the rays through the masks' borders touch the
// surface, and removes points that are inconsistent with them.
#pragma once

#include <vector>

#include "core/values/mesh.h"
#include "views/hull/frontier_points.h"
#include "views/prepared/prepared_view.h"

namespace keypose::reconstruct {

struct FrontierCloudOptions {
  /// a frontier point constrains the surface up to this distance beside it
  double beside_px = 6;
  double reach_px = 16;  ///< and up to this distance above or below it
  /// a point no farther above or below a frontier point is consistent with it
  double agrees_px = 1;
  double errs_px = 1.5;  ///< a point farther above or below is inconsistent with it
  /// a point is removed when it is inconsistent with at least this many frontier points and
  /// consistent with none
  int contradictions = 2;
};

/// Removes points that are inconsistent with frontier points: reflections of a lamp, which stereo
/// matches behind the surface, or false matches on smooth clay. Only points whose normals are
/// similar to those of the frontier points beside them are tested.
/// @param cloud  with normals, colours and confidence
/// @return number of removed points
/// Same bits for any thread count.
int DropWhatFrontierPointsContradict(const std::vector<FrontierPoint>& frontier,
                                     const FrontierCloudOptions& options, PointCloud* cloud);

/// Frontier points with their normals, their view's colour just inside of its outline, and
/// confidence 1.
PointCloud FrontierCloud(const std::vector<FrontierPoint>& frontier,
                         const std::vector<PreparedView>& views);

}  // namespace keypose::reconstruct
