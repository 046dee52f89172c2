// A curve of straight pieces, and the nearest points on parts of it.
#pragma once

#include <vector>

#include "core/values/mesh.h"

namespace keypose::armature {

/// A curve through given points, measured by the length along it. Pieces of no length are allowed.
class Polyline {
 public:
  struct Foot {
    Eigen::Vector3d point = Eigen::Vector3d::Zero();
    /// the curve's direction where the foot can slide both ways; zero at a corner, and at an end of
    /// the part that was searched
    Eigen::Vector3d along = Eigen::Vector3d::Zero();
    double at = 0;                ///< length along the curve up to the foot
    double squared_distance = 0;  ///< from the point that was asked for
  };

  /// @param points  P x 3, from the near end to the far end, P >= 2
  /// @throws InputError  fewer than two points, or one that is not finite
  explicit Polyline(const PointsX3& points);

  double length() const { return ends_.back(); }
  const PointsX3& points() const { return points_; }
  /// The length along the curve up to each of its points: P.
  const std::vector<double>& ends() const { return ends_; }
  /// @param at  clamped to [0, length()]
  Eigen::Vector3d At(double at) const;
  /// The nearest point on the part from `from` to `to`; of several the first.
  Foot Nearest(const Eigen::Vector3d& x, double from, double to) const;

 private:
  int PieceAt(double at) const;

  PointsX3 points_;
  PointsX3 along_;  ///< P-1 x 3, unit; zero for pieces of no length
  std::vector<double> ends_;
};

}  // namespace keypose::armature
