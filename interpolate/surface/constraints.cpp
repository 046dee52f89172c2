#include "interpolate/surface/constraints.h"

#include <algorithm>
#include <queue>

#include "core/errors.h"
#include "core/mesh_checks.h"

namespace keypose::interpolation {

std::vector<ConstraintRow> RowsOf(const Constraints& constraints, int vertex_count) {
  std::vector<ConstraintRow> rows;
  for (const PatchConstraint& patch : constraints.patches) {
    const std::string what = "interpolate: constraint '" + patch.name + "'";
    if (patch.vertices.empty()) throw InputError(what + " has no vertices");
    RequireNotNegative(patch.softness, what + " has a softness that");
    for (const int i : patch.vertices) RequireVertex(i, vertex_count, what, "the keys have", "");
    if (patch.hold == PatchConstraint::Hold::kEveryVertex) {
      for (int i : patch.vertices)
        rows.push_back({{{i, 1.0}}, patch.softness, patch.name + ", vertex " + std::to_string(i)});
    } else {
      ConstraintRow row{{}, patch.softness, patch.name};
      for (int i : patch.vertices)
        row.terms.emplace_back(i, 1.0 / static_cast<double>(patch.vertices.size()));
      rows.push_back(std::move(row));
    }
  }
  return rows;
}

RowTargets TargetsOf(const Constraints& constraints, const PointsX3& v, const PointsX3& u,
                     double t) {
  std::vector<Eigen::Vector3d> targets;
  for (const PatchConstraint& patch : constraints.patches) {
    Eigen::Vector3d straight = Eigen::Vector3d::Zero();
    for (int i : patch.vertices)
      straight += ((1 - t) * v.row(i) + t * u.row(i)).transpose() /
                  static_cast<double>(patch.vertices.size());
    const Eigen::Vector3d goal = patch.path ? patch.path(t) : straight;
    if (!goal.allFinite())
      throw InputError("interpolate: the path of constraint '" + patch.name +
                       "' is not finite at t = " + std::to_string(t));
    if (patch.hold == PatchConstraint::Hold::kCentroid)
      targets.push_back(goal);
    else
      for (int i : patch.vertices)
        targets.push_back(((1 - t) * v.row(i) + t * u.row(i)).transpose() + (goal - straight));
  }
  RowTargets result(static_cast<Eigen::Index>(targets.size()), 3);
  for (std::size_t r = 0; r < targets.size(); ++r) result.row(r) = targets[r];
  return result;
}

std::vector<int> PatchAround(const PointsX3& points, const FacesX3& faces, int seed,
                             double radius) {
  if (seed < 0 || seed >= points.rows())
    throw InputError("interpolate: a patch is wanted round vertex " + std::to_string(seed) +
                     ", which is not there");
  std::vector<char> in(points.rows(), 0);
  const auto near = [&](int i) { return (points.row(i) - points.row(seed)).norm() <= radius; };
  // Grown along edges: another limb that is merely close stays out.
  std::vector<std::vector<int>> around(points.rows());
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    for (int k = 0; k < 3; ++k)
      if (near(faces(f, k)) && near(faces(f, (k + 1) % 3))) {
        around[faces(f, k)].push_back(faces(f, (k + 1) % 3));
        around[faces(f, (k + 1) % 3)].push_back(faces(f, k));
      }
  std::vector<int> patch = {seed};
  in[seed] = 1;
  for (std::size_t at = 0; at < patch.size(); ++at)
    for (int next : around[patch[at]])
      if (!in[next]) in[next] = 1, patch.push_back(next);
  std::sort(patch.begin(), patch.end());
  return patch;
}

}  // namespace keypose::interpolation
