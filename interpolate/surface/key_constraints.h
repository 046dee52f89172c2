// Constraints between keys: pins, patches on a path, the table.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/values/mesh.h"
#include "deform/poisson/poisson.h"

namespace keypose::interpolation {

/// One held patch. Without a path it moves straight from its place in one key to its place in the
/// next. So a foot that is in the same place in both keys does not move.
struct PatchConstraint {
  enum class Hold {
    kEveryVertex,  ///< each vertex of the patch
    kCentroid,     ///< only the mean of its vertices; the patch may turn and stretch
  };
  std::string name;
  std::vector<int> vertices;
  Hold hold = Hold::kEveryVertex;
  /// The patch's centroid at time t (0 at the first key, 1 at the second); empty: straight between
  /// the keys. With kEveryVertex the vertices keep their offsets from it, interpolated between the
  /// keys.
  std::function<Eigen::Vector3d(double t)> path = {};
  /// 0: exact; else a spring of stiffness 1 / softness (cotangent weights are near 1)
  double softness = 0;
};

struct Constraints {
  std::vector<PatchConstraint> patches = {};
  std::optional<Floor> floor = {};
  bool empty() const { return patches.empty() && !floor; }
};

/// Rows for PoissonSystem, three coordinates each: one row per vertex or per patch, in order.
/// @throws InputError  no vertices, a vertex that does not exist, softness that is negative or not
/// finite; names the patch
std::vector<ConstraintRow> RowsOf(const Constraints& constraints, int vertex_count);

/// Targets of RowsOf at time t between keys v and u.
/// @throws InputError  a path that is not finite at t
RowTargets TargetsOf(const Constraints& constraints, const PointsX3& v, const PointsX3& u,
                     double t);

}  // namespace keypose::interpolation
