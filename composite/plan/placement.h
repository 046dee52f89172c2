// Where the character is between two located frames.
#pragma once

#include "core/values/camera.h"
#include "core/values/mesh.h"

namespace keypose::composite {

/// The dominant rigid motion between two shapes: that of the part that moves as one, such as a body
/// whose arms wave.
///
/// @param a, b  V x 3, V >= 3
/// @return  b = R a + t for that part, and each vertex's weight in (0, 1]
/// Iteratively reweighted least squares with Geman and McClure's weights; their scale falls to the
/// median residual. Deterministic.
struct CommonMotion {
  Rigid3 b_from_a;
  Eigen::VectorXd weights;
};
CommonMotion FindCommonMotion(const PointsX3& a, const PointsX3& b);

/// Places a shape between two located ones.
class PlacementBetween {
 public:
  /// @param a_in_world, b_in_world  vertices where the two located frames have them
  PlacementBetween(const PointsX3& a_in_world, const PointsX3& b_in_world);
  /// The vertices of `shape` in world, so that the part that moves as one is a share of its way
  /// from a to b, on a screw about its centroid. What stands still in both stands still between.
  ///
  /// @param shape  V x 3 in its own coordinates
  /// @param scale  of the shape in world
  /// @param share  in [0,1]; 0 gives a's place to a's shape, 1 b's to b's
  PointsX3 Place(const PointsX3& shape, double scale, double share) const;

 private:
  PointsX3 a_, b_;
  CommonMotion motion_;
  Eigen::Vector3d centroid_;  ///< of a's common part
};

}  // namespace keypose::composite
