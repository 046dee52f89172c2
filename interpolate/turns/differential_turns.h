// Faces' rotations between keys, where no consistent rotation vectors exist.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "deform/poisson/poisson.h"
#include "interpolate/maps/face_maps.h"

namespace keypose::interpolation {

/// Each frame's rotations from the relative rotations of neighbouring faces.
///
/// Neighbours' relative rotations D are small even where the rotations themselves wind several
/// times. At time t the wanted relative rotation of every pair is exp(t log D). A tree over the
/// faces, smallest D first, gives the initial rotations. Gauss-Newton then distributes the errors
/// around loops: the rotation residuals of all pairs are the right-hand side of the faces' graph
/// Laplacian. The Laplacian is constant, so one factorisation serves all frames and iterations.
/// Source: relative rotations as in Kircher and Garland 2008 and Lipman et al. 2005; solved on the
/// group with a constant matrix in place of a connection Laplacian per frame.
class DifferentialTurns {
 public:
  /// @param maps    with body_turn
  /// @param system  must outlive this
  DifferentialTurns(const PoissonSystem& system, const SegmentMaps& maps);
  ~DifferentialTurns();
  DifferentialTurns(DifferentialTurns&&) noexcept;

  /// Rotations relative to the body at time t: I at 0, the maps' own at 1.
  std::vector<Eigen::Matrix3d> At(double t) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace keypose::interpolation
