// What one tetrahedron should look like on the way from one key to the other.
#pragma once

#include <Eigen/Core>

#include "interpolate/maps/matrix_powers.h"

namespace keypose::interpolation {

/// A(t) = exp(t turn) F(t), where F(1) = exp(-turn) J: `turn` is what the region turns, F what is
/// left. A(0) = I, A(1) = J.
///
/// F(t) is a power of F: exp(t g) exp(tau(t) (log F - g I)), with the region's growth g going
/// geometrically, and what the tetrahedron's volume does beyond it going straight: a bend, whose
/// inside shrinks as its outside grows, keeps its arc, and a twist, whose F is a pure shear k, is
/// at every moment the shear t k (a power of F's stretch alone is not: it shrinks the bar). Where F
/// has no logarithm (inside out, or turned far from its region) its rotation turns evenly and its
/// stretch goes straight. Going back gives the same path.
class TetPath {
 public:
  /// @param map     J, less the body's turn
  /// @param turn    of the region [rad]
  /// @param growth  log of the region's linear growth
  TetPath(const Eigen::Matrix3d& map, const Eigen::Vector3d& turn, double growth);
  /// Straight from `start` to `end`, for tetrahedra that are no solid in the first key either; less
  /// a body that turns by t body_turn.
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
