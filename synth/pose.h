// Poses as smooth maps of space with exact correspondence: a material point of the rest pose has
// one place in every other pose.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/mesh.h"

namespace keypose::synth {

/// One bend, twist or squash. `x` is where the point is now, `rest` where it was in the rest pose;
/// which points move is decided by `rest`, so that maps compose without chasing each other.
///
/// Source: Barr, Global and Local Deformations of Solid Primitives, SIGGRAPH 1984.
/// Departs: the angle fades out beyond a ball, so that one limb can bend and the others stay.
struct Deformation {
  enum class Kind { kBend, kTwist, kSquash };
  Kind kind = Kind::kBend;
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  ///< [m] a point on the axis, in the rest pose
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();   ///< unit; along the limb
  /// unit, orthogonal to axis; bends turn about it (right hand)
  Eigen::Vector3d hinge = Eigen::Vector3d::UnitX();
  double begin = 0,
         end = 0.1;  ///< [m] along the axis from origin: where the angle starts and is whole
  double angle = 0;  ///< [rad] of bend or twist
  /// squash: length along axis times this, width times 1/sqrt(ratio): volume is kept
  double ratio = 1;
  Eigen::Vector3d center = Eigen::Vector3d::Zero();  ///< [m] of the ball that the deformation is
                                                     ///< confined to, in the rest pose
  /// [m] of that ball: full effect inside, none beyond radius + falloff; 0: everywhere
  double radius = 0;
  double falloff = 0.01;  ///< [m]
  /// the ball sweeps along these points, in the rest pose; empty: it stays at center
  std::vector<Eigen::Vector3d> spine;
  double reach = 0;  ///< [m] of a tube round the axis, in the rest pose: full effect inside, none
                     ///< beyond reach + falloff; 0: everywhere

  Eigen::Vector3d Apply(const Eigen::Vector3d& x, const Eigen::Vector3d& rest) const;
  /// How strongly a material point follows, in [0,1].
  double Weight(const Eigen::Vector3d& rest) const;
};

/// Bends a limb that runs along `axis` from `origin`, between begin and end [m] along it, towards a
/// side; the ball says what belongs to the limb (radius 0: everything).
Deformation LimbBend(const Eigen::Vector3d& origin, const Eigen::Vector3d& axis,
                     const Eigen::Vector3d& towards, double begin, double end, double degrees,
                     const Eigen::Vector3d& center = Eigen::Vector3d::Zero(), double radius = 0);
/// Twists all above z = begin [m] about the character's upright axis, by the whole angle from z =
/// end on.
Deformation TrunkTwist(double begin, double end, double degrees);
/// Presses the whole character down to `ratio` of its height, at the same volume.
Deformation WholeSquash(double ratio);

/// A named shape of the character: deformations one after the other. None: the rest pose.
struct Pose {
  std::string name = "rest";
  std::vector<Deformation> steps;
  /// Two parts are pressed into each other: the solid is the union of what the map gives, and what
  /// one sees of it (OuterSurface) has another topology than the rest pose. The map itself is one
  /// to one on each part.
  bool touches = false;

  Eigen::Vector3d operator()(const Eigen::Vector3d& rest) const;
  PointsX3 operator()(const PointsX3& rest) const;
  /// Derivative at a material point, by central differences of `h` [m].
  Eigen::Matrix3d Jacobian(const Eigen::Vector3d& rest, double h = 1e-6) const;
  /// The material point that the pose carries to `posed`, by Newton's method from `guess`.
  /// @throws SolverError  no convergence: the point is outside of where the map is one to one
  Eigen::Vector3d Inverse(const Eigen::Vector3d& posed, const Eigen::Vector3d& guess) const;
};

}  // namespace keypose::synth
