// Pieces of a surface that may move but not bend, stretch or shear.
#pragma once

#include <vector>

#include "core/mesh.h"

namespace keypose {

/// Connected regions that were painted so stiff that each is to move as one rigid body.
class RigidPieces {
 public:
  static constexpr double kFrom = 100;  ///< stiffness from which on vertices belong to a piece

  RigidPieces() = default;
  /// @param stiffness  V, or empty: no pieces
  /// @param areas      V, of the vertices
  RigidPieces(const FacesX3& faces, const Eigen::VectorXd& stiffness, const Eigen::VectorXd& areas);

  bool empty() const { return pieces_.empty(); }
  const std::vector<std::vector<int>>& pieces() const {
    return pieces_;
  }                                             ///< vertices of each, ascending; three or more
  double area_share() const { return share_; }  ///< of the whole surface

  /// The stiffness that the shape term is to use: stiff edges would only keep a piece from turning
  /// and growing as the surface asks.
  static Eigen::VectorXd Held(const Eigen::VectorXd& stiffness) {
    return (stiffness.array() >= kFrom).select(1, stiffness.array());
  }
  /// Gives all vertices of a piece the rotation that brings its rest shape nearest to where it is.
  void ShareMaps(const PointsX3& rest, const PointsX3& moved,
                 std::vector<Eigen::Matrix3d>& maps) const;
  /// Puts each piece's rest shape where it fits best, and says by which factor the pieces' rest
  /// shapes should grow to fit best.
  double Straighten(const PointsX3& rest, PointsX3& moved) const;

 private:
  std::vector<std::vector<int>> pieces_;
  Eigen::VectorXd areas_;
  double share_ = 0;
};

}  // namespace keypose
