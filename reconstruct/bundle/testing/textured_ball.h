// A ball with a texture that every point of it shows.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <random>
#include <vector>

#include "core/numbers/parallel.h"
#include "core/values/camera.h"
#include "core/values/image.h"
#include "reconstruct/bundle/patch_tracks.h"
#include "reconstruct/testing/known_scenes.h"

namespace keypose::reconstruct {

/// A ball of radius 1 with a texture of waves, and cameras on one ring about z.
struct Ball {
  std::vector<View> views;
  std::vector<PatchImage> images;
};

inline double Texture(const Eigen::Vector3d& x) {
  static const std::vector<Eigen::Vector4d> waves = [] {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> unit(-1, 1);
    std::vector<Eigen::Vector4d> made(16);
    for (Eigen::Vector4d& wave : made)
      for (double& value : wave) value = unit(random);
    return made;
  }();
  double sum = 0;
  for (const Eigen::Vector4d& wave : waves)
    sum += std::sin(28 * wave.head<3>().dot(x) + 3 * wave.w());
  return 128 + 14 * sum;
}

/// Intersection of a pixel's ray with the ball.
inline std::optional<Eigen::Vector3d> OnBall(const View& view, const Eigen::Vector2d& pixel) {
  const Eigen::Vector3d from = view.Center(), along = (view.camera_from_world.rotation.conjugate() *
                                                       view.camera.Unproject(pixel))
                                                          .normalized();
  const double b = from.dot(along), root = b * b - from.squaredNorm() + 1;
  if (root < 0) return std::nullopt;
  return Eigen::Vector3d(from + (-b - std::sqrt(root)) * along);
}

inline Ball MakeBall(int count) {
  Ball ball;
  ball.images.resize(static_cast<std::size_t>(count));
  for (int k = 0; k < count; ++k) ball.views.push_back(testing::BallCamera(k, count));
  ParallelFor(count, [&](std::int64_t k) {
    const View& view = ball.views[k];
    Image8 grey(320, 240, 1, 0), mask = grey;
    for (int y = 0; y < 240; ++y)
      for (int x = 0; x < 320; ++x)
        if (const auto at = OnBall(view, Eigen::Vector2d(x + 0.5, y + 0.5))) {
          *grey.at(x, y) =
              static_cast<std::uint8_t>(std::clamp(std::lround(Texture(*at)), 0L, 255L));
          *mask.at(x, y) = 255;
        }
    ball.images[k] = MakePatchImage(grey, mask, 1, PatchOptions{});
  });
  return ball;
}

}  // namespace keypose::reconstruct
