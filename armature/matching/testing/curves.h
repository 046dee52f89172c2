// Curves that the tests of chains share.
#pragma once

#include <Eigen/Geometry>

#include "armature/matching/polyline.h"
#include "core/values/mesh.h"

namespace keypose::armature {

using Eigen::VectorXd;

/// A hook of pieces of different lengths, and their lengths.
inline Polyline Hook() {
  PointsX3 points(5, 3);
  points << 0, 0, 0, 0, 2, 0, 0.5, 3, 0, 1.5, 3.5, 0.5, 2.5, 3, 1;
  return Polyline(points);
}
inline VectorXd PiecesOf(const Polyline& curve) {
  VectorXd pieces(curve.points().rows() - 1);
  for (Eigen::Index p = 0; p < pieces.size(); ++p)
    pieces[p] = curve.ends()[p + 1] - curve.ends()[p];
  return pieces;
}

}  // namespace keypose::armature
