// Random poses of a character's limbs: each limb is bent at its joints by a random angle, so that
// nothing touches.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "synth/worlds/clay.h"
#include "synth/worlds/pose.h"

namespace keypose::synth {

/// One place where a limb bends, in the rest pose.
struct Joint {
  Eigen::Vector3d origin, axis;        ///< [m]; unit, along the limb towards its tip
  double begin, end;                   ///< [m] along the axis from origin: the part that bends
  double most_deg;                     ///< its share of the limb's angle is in proportion to this
  std::vector<Eigen::Vector3d> spine;  ///< the limb from the joint to its tip [m]
  double radius, falloff;              ///< [m] the limb's points are this near to the spine
};

struct PosableLimb {
  std::string name;
  std::vector<Joint> joints;  ///< from the root to the tip
  Eigen::Vector3d tip;        ///< [m] a material point beyond the last joint
};

struct LimbPoseOptions {
  double least_deg = 30, most_deg = 120;  ///< of each limb's end against its rest pose
  double clearance_m = 0.005;  ///< between parts that are apart in the rest pose, and to the table
  double least_determinant = 0.2;  ///< of the map's derivative, anywhere on the surface
};

/// Rotation of a limb's end against the rest pose [deg], in [0, 180].
double LimbAngleDeg(const Pose& pose, const PosableLimb& limb);

/// A pose 'limbs' in which every limb's end is turned by a random angle within the options' bounds,
/// about a random axis across the limb.
///
/// The map is one to one: its derivative has a positive determinant on the surface, and the posed
/// surface does not intersect itself. Limbs stay over the table, and within a tenth of the rest
/// pose's height and reach, so that they stay in the picture. Where a limb collides, other
/// directions are tried, then smaller angles. The same pose for any resolution of the surface.
/// @throws InputError  a limb cannot be moved by the least angle in any direction tried
Pose RandomLimbPose(const Clay& clay, const std::vector<PosableLimb>& limbs, std::uint64_t seed,
                    const LimbPoseOptions& options = {});

}  // namespace keypose::synth
