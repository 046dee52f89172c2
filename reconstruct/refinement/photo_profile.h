// Photometric consistency of a patch of the surface as it moves in and out along its normal.
#pragma once

#include <vector>

#include "core/values/mesh.h"
#include "reconstruct/refinement/vertex_views.h"
#include "views/prepared/prepared_view.h"

namespace keypose::reconstruct {

/// Costs at offsets (k - steps) * step for k in [0, 2 steps], one row per vertex: 0 when all views
/// show the same texture, 1 when they are unrelated. A row is constant 1 where fewer than two views
/// can be compared.
struct Profiles {
  int steps = 0;            ///< offsets to each side
  double step = 0;          ///< in world units
  std::vector<float> cost;  ///< V x (2 steps + 1)
  int count() const { return 2 * steps + 1; }
  float* Row(std::int64_t v) { return cost.data() + v * count(); }
  const float* Row(std::int64_t v) const { return cost.data() + v * count(); }
};

/// A patch is a tangent square of 8 x 8 samples, at a distance of one pixel of `level` in the view
/// that sees the vertex largest. Its cost is one minus the mean correlation of pairs of views,
/// where each view's contribution is at least 0. The variance of noise is added to each view's
/// variance, so that windows without texture have cost 1 at any offset.
///
/// @param normals  V x 3 unit: the direction of the offsets and of the patch
/// Cost: 8 x 8 samples per vertex, offset and view, about 60 ns with AVX2.
/// Same bits for any thread count on one kind of processor.
Profiles CostProfiles(const PointsX3& points, const PointsX3& normals,
                      const std::vector<VertexViews>& chosen,
                      const std::vector<PreparedView>& views, int level, int steps, double step);

/// The same with plain loops, as used on processors without AVX2; for tests.
Profiles CostProfilesPlain(const PointsX3& points, const PointsX3& normals,
                           const std::vector<VertexViews>& chosen,
                           const std::vector<PreparedView>& views, int level, int steps,
                           double step);

}  // namespace keypose::reconstruct
