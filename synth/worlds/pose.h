// Poses as smooth maps of space with exact correspondence: a material point of the rest pose has
// one position in every other pose.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/values/mesh.h"

namespace keypose::synth {

/// One bend, twist or squash. `x` is the point's current position, `rest` its position in the rest
/// pose. `rest` decides which points move, so the regions of composed maps do not move.
///
/// Source: Barr, Global and Local Deformations of Solid Primitives, SIGGRAPH 1984. Departs: the
/// angle fades out beyond a ball, so that one limb can bend while the others stay.
struct Deformation {
  enum class Kind { kBend, kTwist, kSquash };
  Kind kind = Kind::kBend;
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  ///< [m] a point on the axis, in the rest pose
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();   ///< unit; along the limb
  /// unit, orthogonal to axis; bends turn about it (right hand)
  Eigen::Vector3d hinge = Eigen::Vector3d::UnitX();
  double begin = 0,
         /// [m] along the axis from origin: where the angle starts, and where it is complete
      end = 0.1;
  double angle = 0;  ///< [rad] of bend or twist
  /// squash: factor on the length along the axis; the width is scaled by 1/sqrt(ratio) to keep the
  /// volume
  double ratio = 1;
  /// [m] centre of the ball that limits the deformation, in the rest pose
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  /// [m] radius of that ball: full effect inside, none beyond radius + falloff; 0: no limit
  double radius = 0;
  double falloff = 0.01;  ///< [m]
  /// the ball is swept along these points, in the rest pose; empty: it stays at `center`
  std::vector<Eigen::Vector3d> spine;
  /// [m] radius of a tube around the axis, in the rest pose: full effect inside, none beyond reach
  /// + falloff; 0: no limit
  double reach = 0;

  Eigen::Vector3d Apply(const Eigen::Vector3d& x, const Eigen::Vector3d& rest) const;
  /// Weight of the deformation at a material point, in [0,1].
  double Weight(const Eigen::Vector3d& rest) const;
};

/// Bends a limb along `axis` from `origin` towards a side, between begin and end [m] along the
/// axis. The ball defines which points belong to the limb (radius 0: all).
Deformation LimbBend(const Eigen::Vector3d& origin, const Eigen::Vector3d& axis,
                     const Eigen::Vector3d& towards, double begin, double end, double degrees,
                     const Eigen::Vector3d& center = Eigen::Vector3d::Zero(), double radius = 0);
/// Twists everything above z = begin [m] about the character's vertical axis; the angle is complete
/// from z = end on.
Deformation TrunkTwist(double begin, double end, double degrees);
/// Squashes the whole character to `ratio` of its height, at constant volume.
Deformation WholeSquash(double ratio);

/// A named shape of the character: a sequence of deformations. None: the rest pose.
struct Pose {
  std::string name = "rest";
  std::vector<Deformation> steps;
  /// Two parts are pressed into each other: the solid is the union of the mapped parts, and its
  /// visible surface (OuterSurface) has another topology than the rest pose. The map is one to one
  /// on each part.
  bool touches = false;

  Eigen::Vector3d operator()(const Eigen::Vector3d& rest) const;
  PointsX3 operator()(const PointsX3& rest) const;
  /// Derivative at a material point, by central differences with step `h` [m].
  Eigen::Matrix3d Jacobian(const Eigen::Vector3d& rest, double h = 1e-6) const;
  /// The material point that the pose maps to `posed`, by Newton's method from `guess`.
  /// @throws SolverError  no convergence: at this point the map is not one to one
  Eigen::Vector3d Inverse(const Eigen::Vector3d& posed, const Eigen::Vector3d& guess) const;
};

}  // namespace keypose::synth
