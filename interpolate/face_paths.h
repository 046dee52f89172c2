// What each triangle should look like at any moment of a timeline: turn and stretch on smooth paths through all keys.
#pragma once

#include <Eigen/Core>
#include <map>
#include <vector>

#include "core/mesh.h"
#include "interpolate/face_maps.h"
#include "interpolate/poisson.h"
#include "interpolate/spline.h"
#include "interpolate/turns.h"

namespace keypose::interpolation {

/// log of a symmetric positive definite matrix as (m, d, o) with log S = [m+d o; o m-d], and back.
Eigen::Vector3d LogStretch(const Eigen::Matrix2d& stretch);
Eigen::Matrix2d ExpStretch(const Eigen::Vector3d& log);

/// Paths of all faces through all keys.
///
/// In each span a face goes the way of two keys: edges(s) = R(s) frame S(s) frame^T edges(0), as face_maps.h has it. Where spans meet
/// smoothly, the velocity of each face at the key (its angular velocity in space and the rate of stretch in its plane) is brought to one
/// that both spans share (VelocityAtKey; growth and shear apart), by factors that are one at the keys:
///
///     edges(s) = exp(h(s) . angular) R(s) frame exp(h(s) . stretch) S(s) frame^T edges(0)
///
/// with the cubic Hermite weights h of HermiteWeights. So paths are C1 in time, meet every key exactly whatever the turns (no logarithm of
/// a rotation is taken but the lifted ones of the pairs), reverse with the order of the keys, and with two keys are those of two keys.
/// Source: Kim, Kim & Shin 1995 for splines of rotations as products of exponentials; the correction form is our own.
class FacePaths {
 public:
  /// @param system     of all keys; turns are smoothed with it
  /// @param overrides  for each span the limbs that turn further; or empty
  FacePaths(const std::vector<PointsX3>& keys, const PoissonSystem& system, const Schedule& schedule,
            const std::vector<std::vector<TurnOverride>>& overrides = {}, Stretch stretch = Stretch::kBalanced);

  /// Wanted edges of a face, 3 x 2: from its first corner to its second and third.
  Eigen::Matrix<double, 3, 2> EdgesAt(int span, double way, Eigen::Index face) const;

  const SegmentMaps& maps(int span) const { return maps_[span]; }
  const TurnReport& turns(int span) const { return turns_[span]; }
  int degenerate_faces() const;  ///< most, of any span

 private:
  /// Wanted less own velocity at a span's ends.
  struct Bend {
    Eigen::Vector3d angular = Eigen::Vector3d::Zero();  ///< in the world
    Eigen::Vector3d stretch = Eigen::Vector3d::Zero();  ///< as LogStretch has it, in the axes R(s) frame
  };
  struct BendPair {
    Bend start, end;
  };
  using Straight = Eigen::Matrix<double, 6, 1>;  ///< both edges of a face that has no map somewhere

  void SmoothFace(const Schedule& schedule, Eigen::Index face);
  void SmoothStraight(const Schedule& schedule, Eigen::Index face);

  FacesX3 faces_;
  Stretch stretch_;
  std::vector<SegmentMaps> maps_;                                ///< spans
  std::vector<TurnReport> turns_;                                ///< spans
  std::vector<std::vector<Eigen::Matrix<double, 3, 2>>> edges_;  ///< keys x F: from first corner to second and third
  std::vector<std::vector<BendPair>> bends_;                     ///< spans x F, or empty when nothing is to be smoothed
  std::map<Eigen::Index, EndVelocities<Straight>> straight_;     ///< bends of faces without area in some key
};

}  // namespace keypose::interpolation
