#include "interpolate/surface/key_constraints.h"

#include <algorithm>
#include <iterator>
#include <queue>

#include "core/surfaces/mesh_checks.h"
#include "core/values/errors.h"

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
  RowTargets result(std::ssize(targets), 3);
  for (std::size_t r = 0; r < targets.size(); ++r) result.row(r) = targets[r];
  return result;
}

}  // namespace keypose::interpolation
