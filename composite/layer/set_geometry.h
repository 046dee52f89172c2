// The set as a mesh: props and furniture that hide the character, and that its shadow falls on.
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "composite/layer/table_shadow.h"
#include "core/surfaces/ray_scene.h"
#include "core/values/mesh.h"

namespace keypose::composite {

struct SetGeometry {
  /// @param set  in the shot's world; open surfaces are fine
  /// @throws InputError  no faces
  explicit SetGeometry(const Mesh& set)
      : points(set.points), faces(set.faces), scene(points, faces) {}
  PointsX3 points;
  FacesX3 faces;
  RayScene scene;
};

/// The shadow of one frame on a set.
class SetShadow {
 public:
  /// @param strength  as it was learnt on the table: shares of the light of a level place
  SetShadow(const RayScene& figure, const SetGeometry& set, const Ground& table,
            const ShadowStrength& strength);
  /// The share of its light that a place of the set keeps, in [0, 1]. A place turned from the lamp,
  /// or in the set's own shadow, has none of the lamp's light to lose.
  ///
  /// @param eye  that sees the place, on the side that counts
  double Kept(const Eigen::Vector3d& place, int face, const Eigen::Vector3d& eye) const;

 private:
  struct Light {
    double seen = 0, hidden = 0;  ///< shares: without the figure, and of that taken by it
  };
  Light Rays(const Eigen::Vector3d& from, const std::vector<Eigen::Vector3d>& rays,
             const Eigen::Quaterniond& turn, const Eigen::Vector3d& normal) const;

  const RayScene& figure_;
  const SetGeometry& set_;
  Ground table_;
  ShadowStrength strength_;
  std::vector<Eigen::Vector3d> lamp_, sky_;  ///< unit; the sky's around +z
};

}  // namespace keypose::composite
