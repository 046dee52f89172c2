// Test scenes that several test files share.
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "core/values/landmark_goal.h"
#include "core/values/mesh.h"

namespace keypose::registration {

/// A landmark on a vertex.
inline LandmarkGoal At(int vertex, const Eigen::Vector3d& target) {
  LandmarkGoal goal;
  goal.name = std::to_string(vertex);
  goal.source.vertices.setConstant(vertex);
  goal.target = target;
  return goal;
}

/// A landmark on every `stride`-th vertex.
inline std::vector<LandmarkGoal> Every(int stride, const PointsX3& truth) {
  std::vector<LandmarkGoal> goals;
  for (int v = 0; v < truth.rows(); v += stride) goals.push_back(At(v, truth.row(v)));
  return goals;
}

/// Bends a tube along z through `angle` over its length, about an axis beside it.
inline PointsX3 Bent(const PointsX3& points, double length, double angle) {
  PointsX3 bent = points;
  const double radius = length / angle;
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    const double a = points(i, 2) / radius, r = radius - points(i, 0);
    bent.row(i) << radius - r * std::cos(a), points(i, 1), r * std::sin(a);
  }
  return bent;
}

/// Both meshes in one, unconnected.
inline Mesh Joined(const Mesh& a, const Mesh& b) {
  Mesh both;
  both.points.resize(a.vertex_count() + b.vertex_count(), 3);
  both.points << a.points, b.points;
  both.faces.resize(a.face_count() + b.face_count(), 3);
  both.faces << a.faces, (b.faces.array() + a.vertex_count()).matrix();
  return both;
}

}  // namespace keypose::registration
