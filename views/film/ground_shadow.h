// The soft shadow of a figure on the table that it stands on.
#pragma once

#include <vector>

#include "core/surfaces/ray_scene.h"
#include "core/values/mesh.h"

namespace keypose {

/// A table, horizontal at the lowest point of an animation.
struct Ground {
  Eigen::Vector3d origin;           ///< on the table, below the middle of the figure
  Eigen::Vector3d right, back, up;  ///< unit, orthogonal; right and back lie in the table
  double reach = 1;     ///< half the side of a square round the origin that is below all the figure
  double diagonal = 1;  ///< of the figure's bounding box

  /// The point as (right, back, up) from the origin.
  Eigen::Vector3d Local(const Eigen::Vector3d& point) const;
};

/// @param frames  at least one, with vertices
/// @param up      unit; +y or +z
Ground GroundUnder(const std::vector<Mesh>& frames, const Eigen::Vector3d& up);

/// How much of an even sky the figure hides from each point of the table, weighted by the cosine to
/// the vertical: what a matt table loses of its light (ambient occlusion). It is computed once on
/// grids of three sizes, for any number of pictures; 256 directions per point, of which each point
/// of a grid takes 16 and shares them with its neighbours. Nothing flickers, since neither
/// directions nor grids depend on the frame.
/// Same bits for any thread count.
///
/// Sources: Shirley and Chiu, A low distortion map between disk and square, 1997 (directions);
/// Keller and Heidrich, Interleaved sampling, 2001; Sobol's sequence as by Kollig and Keller, 2002.
class GroundShadow {
 public:
  /// @param figure  above the ground
  GroundShadow(const RayScene& figure, const Ground& ground);

  /// The hidden share, in [0, 1], at a point of the table; 0 far away.
  double Hidden(const Eigen::Vector3d& point) const;

 private:
  struct Grid {
    double half_side = 0;
    std::vector<float> hidden;  ///< kSide^2, rows of increasing `back`
    double At(double right, double back) const;
  };
  Ground ground_;
  std::vector<Grid> grids_;  ///< from small and fine to large and coarse
};

}  // namespace keypose
