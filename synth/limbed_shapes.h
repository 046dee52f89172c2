// Clay things with limbs that bend far: what registration is tried on.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "synth/clay.h"
#include "synth/pose.h"

namespace keypose::synth {

/// A named point of the surface in the rest pose.
struct Place {
  std::string name;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< [m] on the solid
};

/// A solid, one pose of it, and named places: the most telling first.
struct LimbedShape {
  Clay clay;
  Pose pose;
  std::vector<Place> places;
};

struct LimbedShapeOptions {
  std::uint64_t seed = 0;  ///< 0: the plain proportions; others vary them and the plane of each
                           ///< bend. The solid does not depend on the rest
  std::string shape = "tentacle";  ///< tentacle | character
  double bend_deg = 180;  ///< of the tentacle; the character's five limbs bend by 0.6 to 1 of it,
                          ///< each its own way
  double twist_deg = 0;   ///< of each limb round its own axis, from its root to its tip
  double squash = 1;      ///< height times this, widths by its inverse root
  int places = 13;        ///< tips and body first, then along the limbs

  std::vector<std::string> Problems() const;
};

/// tentacle: a bulb with eyes and a tapered limb, 0.2 m long and 0.012 m thick, that leaves it
/// straight along z and bends with constant curvature. character: torso, head, two arms, two legs,
/// a tail. The pose is one to one on the solid: parts that are far apart in the rest pose stay 8 mm
/// apart, or another plane is tried.
///
/// @throws UsageError  an option out of range or of an unknown name
/// @throws InputError  no plane found in which the limbs stay apart
LimbedShape MakeLimbedShape(const LimbedShapeOptions& options);

}  // namespace keypose::synth
