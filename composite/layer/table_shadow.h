// What the character takes of the light on the table that it stands on: of an even sky, which makes
// the contact shadow, and of one soft lamp.
#pragma once

#include <vector>

#include "core/surfaces/ray_scene.h"
#include "core/values/mesh.h"
#include "views/film/ground_shadow.h"

namespace keypose::composite {

/// A soft lamp, far away.
struct SoftLamp {
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();  ///< unit, towards it
  double radius_rad = 0.1;                               ///< of its disk
};

/// Rays spread evenly over a lamp's disk.
std::vector<Eigen::Vector3d> RaysTo(const SoftLamp& lamp, int count);

/// How much light of one frame's shadow is taken: share = 1 - sky * hidden sky - lamp * hidden
/// lamp.
struct ShadowStrength {
  double sky = 0, lamp = 0;
  SoftLamp light;
};

/// The shadow of one frame.
/// Same bits for any thread count.
class TableShadow {
 public:
  /// @param figure  above the ground
  TableShadow(const RayScene& figure, const Ground& ground, const ShadowStrength& strength);
  /// The share of its light that a point of the table keeps, in [0, 1]; 1 far away.
  double Kept(const Eigen::Vector3d& point) const;

 private:
  double HiddenLamp(const Eigen::Vector3d& point) const;

  Ground ground_;
  ShadowStrength strength_;
  GroundShadow sky_;
  // The grid of the lamp's shadow: columns lead away from the lamp, as far as the shadow goes.
  Eigen::Vector3d away_, across_;  // unit, on the table
  double near_ = 0, half_width_ = 0, cell_ = 1;
  int columns_ = 0, rows_ = 0;
  std::vector<float> lamp_;  ///< rows_ x columns_
};

}  // namespace keypose::composite
