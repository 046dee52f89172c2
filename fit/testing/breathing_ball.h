// A painted ball that breathes between several cameras: a small world with known truth for tests of
// meshes that follow films.
#pragma once

#include <vector>

#include "core/values/camera.h"
#include "core/values/image.h"
#include "core/values/mesh.h"
#include "fit/following/follow.h"

namespace keypose::fit {

struct BreathingBall {
  static constexpr int kSize = 150, kFrames = 4;
  static constexpr double kPixel = 6 / (1.9 * kSize);  ///< on the ball

  Mesh mesh;                ///< a unit sphere that does not breathe
  Mesh fine;                ///< the ball at rest, with colours of its vertices
  std::vector<View> views;  ///< a ring about the origin

  explicit BreathingBall(int cameras = 6);
  /// The ball's points in a frame: larger than the sphere, with a bulge that comes and goes.
  PointsX3 Truth(const PointsX3& sphere, int frame) const;
  Image8 Picture(int view, int frame) const;  ///< RGB
  Image8 Mask(int view, int frame) const;
  std::vector<PreparedView> Film(int frame) const;
  /// The films, beside `mesh` in each frame.
  FollowSource Source() const;
  /// Mean distance of the points from the true surface.
  double Error(const PointsX3& points, int frame) const;

 private:
  Image8 Cutout(int view, int frame) const;
};

}  // namespace keypose::fit
