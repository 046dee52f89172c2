// Frames whose enclosed volume is the one that was asked for.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "core/mesh.h"
#include "deform/poisson/poisson.h"

namespace keypose::interpolation {

/// Moves vertices along a smooth outward field until each closed part encloses the wanted volume.
///
/// The field z = (H + kappa M)^-1 grad(volume) is the displacement that gains volume at the least
/// stretch; screening keeps it from reaching across the whole body, and what would move a
/// constraint row is projected out. Along it the volume is a cubic polynomial of the step, whose
/// root nearest to zero is found to rounding: no iteration over solves. Parts that are open in the
/// mesh are left alone.
/// Source: recipe of volume-constrained deformation by one Lagrange multiplier; Huang et al. 2006
/// for the constraint.
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
    int unreachable = 0;      ///< parts with no root within reach: left as they were
  };
  /// Moves `points` along `direction` in place. Parts whose target is NaN are left alone.
  /// @param direction  from Direction, of these points or of points near them
  /// @param targets    one a part; see PathVolumes
  /// @param held       vertices whose z must not change either (those on a floor)
  Result Apply(PointsX3& points, PointsX3 direction, const std::vector<double>& targets,
               const std::vector<int>& held = {}) const;

 private:
  std::vector<std::array<double, 4>> Polynomials(const PointsX3& points,
                                                 const PointsX3* direction) const;

  const PoissonSystem* system_;
  std::vector<char> closed_;
  std::vector<int> origins_;  // a vertex of each part
};

/// The step along a direction after which a part's volume, a cubic polynomial of the step, is
/// `target`: the root nearest to zero. NaN where there is none to be found.
double StepToVolume(std::array<double, 4> volume, double target);

/// v0^(1-t) v1^t for each part; NaN (left alone) where a volume is 0 or the two have different
/// signs.
std::vector<double> PathVolumes(const std::vector<double>& v0, const std::vector<double>& v1,
                                double t);

}  // namespace keypose::interpolation
