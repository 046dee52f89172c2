// A limb as a chain of joints between rings that stay rigid.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/values/camera.h"
#include "fit/limbs/limbs.h"

namespace keypose::fit {

/// Bends a limb that is already bent: each piece of it lies as its shape at rest does, moved
/// rigidly to where the piece is now, so a limb that was squeezed into a wrong place is whole
/// again.
class LimbChain {
 public:
  static constexpr int kJoints = 3, kTurns = 3 * kJoints;
  /// Rotation vectors [rad] of the joints, from the body's to the tip's.
  using Turns = Eigen::Matrix<double, kTurns, 1>;

  /// @param rest  V x 3, of all vertices
  /// @param now   V x 3
  LimbChain(const Limb& limb, const PointsX3& rest, const PointsX3& now);
  /// The limb's vertices, in its order, with the joints turned.
  PointsX3 Turned(const Turns& turns) const;
  /// Some of them.
  /// @param some  indices into the limb's vertices
  PointsX3 Turned(const Turns& turns, const std::vector<int>& some) const;

 private:
  struct Ring {
    double along;
    Rigid3 now_from_rest;
  };
  void AddRings(const PointsX3& now);
  std::vector<Rigid3> TurnedRings(const Turns& turns) const;
  Eigen::RowVector3d On(const std::vector<Rigid3>& rings, int vertex) const;
  void PlaceJoints(const PointsX3& now);
  double Radius() const;
  Rigid3 At(double along, const PointsX3& now) const;

  const Limb& limb_;
  PointsX3 rest_;
  std::vector<Ring> rings_;             // from the tip on
  std::vector<double> joint_along_;     // from the body on
  std::vector<Eigen::Vector3d> joint_;  // where they are now
};

}  // namespace keypose::fit
