// The way of a camera that moves from filmed frame to filmed frame.
#pragma once

#include <vector>

#include "core/values/camera.h"

namespace keypose::composite {

/// Where the camera was when a frame was filmed.
struct CameraKnot {
  double time = 0;  ///< in any unit
  Rigid3 camera_from_world;
};

/// A smooth way through all knots: cubics through centres and rotation vectors, whose speeds at a
/// knot are those of the parabola through it and its neighbours. A camera that moves evenly, or
/// with an even acceleration, is followed exactly in its centre. The knots themselves are kept as
/// they are, since a camera that was moved by hand trembles, and its plates with it.
class CameraPath {
 public:
  /// @param knots  ascending in time, at least one; neighbours less than half a turn apart
  /// @throws InputError  none, or not ascending
  explicit CameraPath(std::vector<CameraKnot> knots);
  /// @param time  before the first knot and after the last one the camera stands
  Rigid3 At(double time) const;

  /// Where a knot would be by the cubic through two knots on each side of it.
  struct Smooth {
    Rigid3 camera_from_world;
    /// A path whose knots have independent errors differs from this by so many of their deviations.
    double gain = 1;
  };
  /// @param knot  with two knots on either side
  Smooth SmoothAt(int knot) const;

 private:
  using Place = Eigen::Matrix<double, 6, 1>;  // centre; rotation vector from a knot's rotation
  Place PlaceOf(int knot, int from) const;
  Rigid3 CameraOf(const Place& place, int from) const;
  Place SpeedAt(int knot, int from) const;

  std::vector<CameraKnot> knots_;
  std::vector<Rigid3> world_from_camera_;
};

}  // namespace keypose::composite
