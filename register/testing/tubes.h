// Tubes of two tessellations that the tests of the default method bend, and their errors.
#pragma once

#include <vector>

#include "core/surfaces/geometry.h"
#include "core/surfaces/shapes.h"
#include "register/testing/scenes.h"

namespace keypose::registration {

constexpr double kRadius = 0.12, kLength = 2;
constexpr int kSegments = 20, kRings = 40, kGoalStride = 63;
inline Mesh Tube() { return MakeCylinder(kRadius, kLength, kSegments, kRings); }
inline Mesh OtherTube() { return MakeCylinder(kRadius, kLength, 23, 47); }

inline Mesh WithPoints(Mesh mesh, const PointsX3& points) {
  mesh.points = points;
  return mesh;
}

inline Eigen::VectorXd Errors(const PointsX3& found, const PointsX3& truth) {
  return (found - truth).rowwise().norm() / BoundingDiagonal(truth);
}

/// Number of faces whose normal opposes that of the true face.
inline int Inverted(const FacesX3& faces, const PointsX3& found, const PointsX3& truth) {
  return static_cast<int>(
      (FaceNormals(found, faces).cwiseProduct(FaceNormals(truth, faces)).rowwise().sum().array() <=
       0)
          .count());
}

}  // namespace keypose::registration
