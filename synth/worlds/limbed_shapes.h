// Clay figures with strongly bent limbs, as test cases for registration.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "synth/worlds/clay.h"
#include "synth/worlds/pose.h"

namespace keypose::synth {

/// A named point of the surface in the rest pose.
struct Place {
  std::string name;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< [m] on the solid
};

/// A solid, one pose of it, and named places, the most distinctive first.
struct LimbedShape {
  Clay clay;
  Pose pose;
  std::vector<Place> places;
};

struct LimbedShapeOptions {
  /// 0: standard proportions; others vary them and the plane of each bend. The solid depends only
  /// on `seed` and `shape`
  std::uint64_t seed = 0;
  std::string shape = "tentacle";  ///< tentacle | character
  /// of the tentacle; the character's five limbs bend by 0.6 to 1 of it, in different directions
  double bend_deg = 180;
  double twist_deg = 0;  ///< of each limb about its own axis, from root to tip
  double squash = 1;     ///< factor on the height; widths are divided by its square root
  int places = 13;       ///< number of places: tips and body first, then along the limbs

  std::vector<std::string> Problems() const;
};

/// tentacle: a bulb with eyes and a tapered limb, 0.2 m long and 0.012 m thick, that starts along z
/// and bends with constant curvature. character: torso, head, two arms, two legs, a tail. The pose
/// is one to one on the solid: parts that are far apart in the rest pose stay 8 mm apart; otherwise
/// other bending planes are tried.
///
/// @throws UsageError  an option is out of range, or a name is unknown
/// @throws InputError  no bending plane found that keeps the limbs apart
LimbedShape MakeLimbedShape(const LimbedShapeOptions& options);

}  // namespace keypose::synth
