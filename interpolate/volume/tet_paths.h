// The wanted map of one tetrahedron between two keys.
#pragma once

#include <Eigen/Core>

#include "interpolate/maps/matrix_powers.h"

namespace keypose::interpolation {

/// A(t) = exp(t turn) F(t), where F(1) = exp(-turn) J: `turn` is the region's turn, F the rest.
/// A(0) = I, A(1) = J.
///
/// F(t) is a power of F: exp(t g) exp(tau(t) (log F - g I)). The region's growth g is geometric;
/// the rest of the tetrahedron's volume change is linear in t. So a bend, whose inside shrinks as
/// its outside grows, keeps its arc. A twist, whose F is a pure shear k, is the shear t k at every
/// moment (a power of F's stretch alone would shrink the bar). Where F has no logarithm (inverted,
/// or turned far from its region) its rotation has constant speed and its stretch is linear.
/// Swapped ends give the reversed path.
class TetPath {
 public:
  /// @param map     J, relative to the body's turn
  /// @param turn    of the region [rad]
  /// @param growth  log of the region's linear growth
  TetPath(const Eigen::Matrix3d& map, const Eigen::Vector3d& turn, double growth);
  /// Linear from `start` to `end`, for tetrahedra that are inverted in the first key as well,
  /// relative to a body that turns by t body_turn.
  static TetPath Straight(const Eigen::Matrix3d& start, const Eigen::Matrix3d& end,
                          const Eigen::Vector3d& body_turn);
  Eigen::Matrix3d At(double t) const;
  bool has_power() const { return has_power_; }

 private:
  TetPath() = default;
  Eigen::Vector3d turn_, remainder_;
  MatrixExponential power_;                                        ///< of log F - g I
  Eigen::Matrix3d start_ = Eigen::Matrix3d::Identity(), stretch_;  ///< without a power
  double growth_ = 0, volume_log_ = 0, volume_gain_ = 0;
  bool has_power_ = false;
};

}  // namespace keypose::interpolation
