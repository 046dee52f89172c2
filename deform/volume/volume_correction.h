// Frames that enclose a wanted volume.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "core/values/mesh.h"
#include "deform/poisson/poisson.h"

namespace keypose {

/// Moves vertices along a smooth outward field until each closed part encloses the wanted volume.
///
/// The field z = (H + kappa M)^-1 grad(volume) is the displacement that gains volume at the least
/// stretch. Screening limits its reach across the body, and components that would move a constraint
/// row are projected out. Along the field the volume is a cubic polynomial of the step. Its root
/// nearest to zero is found to rounding, without further solves. Open parts are not corrected.
/// Source: volume-constrained deformation with one Lagrange multiplier; Huang et al. 2006 for the
/// constraint.
class VolumeCorrection {
 public:
  /// @param system  built with options.screened; must outlive this
  explicit VolumeCorrection(const PoissonSystem& system);

  /// Per part: 1 where every edge has two faces, in opposite directions.
  const std::vector<char>& closed_parts() const { return closed_; }
  /// Signed volume of each part; 0 for open ones.
  std::vector<double> Volumes(const PointsX3& points) const;
  /// z at these points: V x 3, scaled to a largest entry of 1. One solve with three right-hand
  /// sides.
  PointsX3 Direction(const PointsX3& points) const;
  /// Directions of several shapes with one batch of solves.
  std::vector<PointsX3> Directions(const KeyRefs& shapes) const;

  struct Result {
    double largest_move = 0;  ///< of any vertex
    int corrected = 0;        ///< parts
    int unreachable = 0;      ///< parts whose root is out of reach: not corrected
  };
  /// Moves `points` along `direction` in place. Parts whose target is NaN are not corrected.
  /// @param direction  from Direction, of these points or of points near them
  /// @param targets    one per part; see PathVolumes
  /// @param held       vertices whose z must not change either (those on a floor)
  Result Apply(PointsX3& points, PointsX3 direction, const std::vector<double>& targets,
               const std::vector<int>& held = {}) const;

 private:
  std::vector<std::array<double, 4>> Polynomials(const PointsX3& points,
                                                 const PointsX3* direction) const;

  const PoissonSystem* system_;
  std::vector<char> closed_;
  std::vector<int> origins_;  // one vertex of each part
};

/// The step along a direction at which a part's volume, a cubic polynomial of the step, is
/// `target`: the root nearest to zero. NaN where none is found.
double StepToVolume(std::array<double, 4> volume, double target);

/// v0^(1-t) v1^t for each part; NaN (no correction) where a volume is 0 or the signs differ.
std::vector<double> PathVolumes(const std::vector<double>& v0, const std::vector<double>& v1,
                                double t);

}  // namespace keypose
