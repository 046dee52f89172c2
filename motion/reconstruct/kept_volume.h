// Poses that keep the volume of the rest shape.
#pragma once

#include <vector>

#include "core/mesh.h"
#include "deform/poisson/poisson.h"

namespace keypose::motion {

/// Moves poses along their normals until each closed part has its volume at rest, to 1e-5.
///
/// How far each vertex moves along its normal, relative to the others, is found once, at rest: the
/// field that gains volume at the least stretch (VolumeCorrection). So a pose costs no solve, and
/// mostly one pass over the faces: the gradient of the volume gives normals, volume (a third of the
/// gradient's product with the points) and slope; the curvature along the field is that at rest.
class KeptVolume {
 public:
  /// @param system  built with screening; must outlive this
  KeptVolume(const PoissonSystem& system, const PointsX3& rest);

  struct Result {
    double deviation = 0;     ///< largest |volume / rest - 1| of a part before
    double largest_move = 0;  ///< of a vertex
  };
  /// Parts whose volume is out of reach (a quarter of the diagonal) are left alone.
  Result Apply(PointsX3& pose) const;
  bool any_closed() const { return any_closed_; }

 private:
  /// Of each part: volume, and its derivative along the field.
  struct State {
    std::vector<double> volume, slope;
    PointsX3 field;  ///< V x 3
  };
  State StateOf(const PointsX3& pose) const;

  const PoissonSystem* system_;
  std::vector<char> closed_;
  std::vector<double> volume_, curvature_;  // of each part at rest
  Eigen::VectorXd amount_;                  // V, along the normal
  double diagonal_ = 1;
  bool any_closed_ = false;
};

}  // namespace keypose::motion
