// How well photographs agree on a patch of the surface as it is pushed in and out along its normal.
#pragma once

#include <vector>

#include "core/mesh.h"
#include "reconstruct/refinement/vertex_views.h"
#include "views/prepared/prepared_view.h"

namespace keypose::reconstruct {

/// Costs at offsets (k - steps) * step for k in [0, 2 steps], one row a vertex: 0 when all views
/// show the same texture, 1 when unrelated. A row is constant 1 where fewer than two views can be
/// compared.
struct Profiles {
  int steps = 0;            ///< offsets to either side
  double step = 0;          ///< world length
  std::vector<float> cost;  ///< V x (2 steps + 1)
  int count() const { return 2 * steps + 1; }
  float* Row(std::int64_t v) { return cost.data() + v * count(); }
  const float* Row(std::int64_t v) const { return cost.data() + v * count(); }
};

/// A patch is a tangent square of 8 x 8 samples, a pixel of `level` apart in the view that sees the
/// vertex largest. Its cost is one minus the mean correlation of pairs of views, each view's share
/// not below 0; the variance of noise is added to each view's, so that windows without texture cost
/// 1 at any offset.
///
/// @param normals  V x 3 unit: the direction of the offsets and of the patch
/// Cost: 8 x 8 samples a vertex, offset and view, about 60 ns with AVX2.
/// Same bits for any thread count on one kind of processor.
Profiles CostProfiles(const PointsX3& points, const PointsX3& normals,
                      const std::vector<VertexViews>& chosen,
                      const std::vector<PreparedView>& views, int level, int steps, double step);

/// The same with the plain loops that stand in where a processor lacks AVX2; for tests.
Profiles CostProfilesPlain(const PointsX3& points, const PointsX3& normals,
                           const std::vector<VertexViews>& chosen,
                           const std::vector<PreparedView>& views, int level, int steps,
                           double step);

}  // namespace keypose::reconstruct
