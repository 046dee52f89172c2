// Pieces of a surface that can move but not bend, stretch or shear.
#pragma once

#include <vector>

#include "core/values/mesh.h"

namespace keypose {

/// Connected regions with such a high stiffness that each moves as a rigid body.
class RigidPieces {
 public:
  static constexpr double kFrom = 100;  ///< lowest stiffness of vertices in a piece

  RigidPieces() = default;
  /// @param stiffness  V, or empty: no pieces
  /// @param areas      V, of the vertices
  RigidPieces(const FacesX3& faces, const Eigen::VectorXd& stiffness, const Eigen::VectorXd& areas);

  bool empty() const { return pieces_.empty(); }
  const std::vector<std::vector<int>>& pieces() const {
    return pieces_;
  }                                             ///< vertices of each, ascending; three or more
  double area_share() const { return share_; }  ///< of the whole surface

  /// The stiffness for the shape term: 1 in rigid pieces. Stiff edges would only hinder the
  /// rotation and scaling of a piece.
  static Eigen::VectorXd Held(const Eigen::VectorXd& stiffness) {
    return (stiffness.array() >= kFrom).select(1, stiffness.array());
  }
  /// Sets the maps of all vertices of a piece to the rotation that aligns its rest shape best with
  /// `moved`.
  void ShareMaps(const PointsX3& rest, const PointsX3& moved,
                 std::vector<Eigen::Matrix3d>& maps) const;
  /// Replaces each piece in `moved` by its best fitting rest shape. Returns the factor on the
  /// pieces' rest shapes that fits best.
  double Straighten(const PointsX3& rest, PointsX3& moved) const;

 private:
  std::vector<std::vector<int>> pieces_;
  Eigen::VectorXd areas_;
  double share_ = 0;
};

}  // namespace keypose
