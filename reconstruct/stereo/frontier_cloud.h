// Frontier points in a cloud: where the rays of the masks' outlines touch the surface, points are
// put, and points that contradict them go.
#pragma once

#include <vector>

#include "core/mesh.h"
#include "views/hull/frontier_points.h"
#include "views/prepared/prepared_view.h"

namespace keypose::reconstruct {

struct FrontierCloudOptions {
  /// how far beside a frontier point, along the surface, it says where the surface is
  double beside_px = 6;
  double reach_px = 16;  ///< how far above or below it
  double agrees_px = 1;  ///< a point no farther above or below a frontier point agrees with it
  double errs_px = 1.5;  ///< and one that is farther contradicts it
  /// frontier points that have to be contradicted, and none agreed with, for a point to go
  int contradictions = 2;
};

/// Takes out what frontier points contradict: a lamp's image in gloss, which photographs match
/// behind the surface, or a chance match on smooth clay. Only points that face as the frontier
/// points beside them do are judged.
/// @param cloud  with normals, colours and confidence
/// @return how many went.
/// Same bits for any thread count.
int DropWhatFrontierPointsContradict(const std::vector<FrontierPoint>& frontier,
                                     const FrontierCloudOptions& options, PointCloud* cloud);

/// Frontier points with their normals, the colour that their view shows just inside of its outline,
/// and confidence 1.
PointCloud FrontierCloud(const std::vector<FrontierPoint>& frontier,
                         const std::vector<PreparedView>& views);

}  // namespace keypose::reconstruct
