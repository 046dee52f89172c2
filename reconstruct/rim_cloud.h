// Rim points in a cloud: where the masks' rims touch the surface, points are put, and points that contradict them go.
#pragma once

#include <vector>

#include "core/mesh.h"
#include "reconstruct/dense_view.h"
#include "reconstruct/rim_points.h"

namespace keypose::reconstruct {

struct RimCloudOptions {
  double beside_px = 6;  ///< how far beside a rim point, along the surface, it says where the surface is
  double reach_px = 16;  ///< how far above or below it
  double agrees_px = 1;  ///< a point no farther above or below a rim point agrees with it
  double errs_px = 1.5;  ///< and one that is farther contradicts it
  int witnesses = 2;     ///< rim points that have to be contradicted, and none agreed with, for a point to go
};

/// Takes out what rims contradict: a lamp's image in gloss, which photographs match behind the surface, or a chance match on smooth clay.
/// Only points that face as the rims beside them do are judged.
/// @param cloud  with normals, colours and confidence
/// @return how many went. Same bits for any thread count.
int DropWhatRimsContradict(const std::vector<RimPoint>& rims, const RimCloudOptions& options, PointCloud* cloud);

/// Rim points with their normals, the colour that their view shows just inside of its rim, and confidence 1.
PointCloud RimCloud(const std::vector<RimPoint>& rims, const std::vector<DenseView>& views);

}  // namespace keypose::reconstruct
