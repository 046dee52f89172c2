// Poses that keep the volume of the rest shape.
#pragma once

#include <vector>

#include "core/mesh.h"
#include "deform/poisson/poisson.h"
#include "deform/volume/volume_correction.h"

namespace keypose::motion {

/// Moves poses along their normals until each closed part has its volume at rest. How far each
/// vertex moves along its normal, relative to the others, is found once, at rest: the field that
/// gains volume at the least stretch (VolumeCorrection). So a pose costs no solve.
class KeptVolume {
 public:
  /// @param system  built with screening; must outlive this
  KeptVolume(const PoissonSystem& system, const PointsX3& rest);
  /// @return what was moved; largest_move in the mesh's unit
  VolumeCorrection::Result Apply(PointsX3& pose) const;
  /// Sum of the closed parts' volumes, over that at rest; 1 where no part is closed.
  double VolumeOf(const PointsX3& pose) const;
  bool any_closed() const { return rest_sum_ != 0; }

 private:
  const PoissonSystem* system_;
  VolumeCorrection correction_;
  std::vector<double> rest_volumes_;
  double rest_sum_ = 0;
  Eigen::VectorXd amount_;  // V, along the normal
};

}  // namespace keypose::motion
