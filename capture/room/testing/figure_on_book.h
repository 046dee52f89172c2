// A figure on a book on a table beside a box: what cameras around it see.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "capture/room/coarse_depths.h"
#include "capture/room/standing_figure.h"
#include "capture/testing/test_images.h"
#include "core/numbers/parallel.h"
#include "core/values/camera.h"
#include "core/values/image.h"

namespace keypose::capture {

constexpr double kFar = std::numeric_limits<double>::infinity();
constexpr double kBookTop = 0.04, kFigureRadius = 0.09, kFigureTop = 0.4;
enum Thing { kNothing, kTable, kBook, kFigure, kBox };

struct Hit {
  double t = kFar;
  Thing thing = kNothing;
};

/// Along a ray, the nearest side of an upright box.
inline double AlongBox(const Eigen::Vector3d& from, const Eigen::Vector3d& ray,
                       const Eigen::Vector3d& low, const Eigen::Vector3d& high) {
  double enter = 0, leave = kFar;
  for (int k = 0; k < 3; ++k) {
    const double a = (low[k] - from[k]) / ray[k], b = (high[k] - from[k]) / ray[k];
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  return enter < leave ? enter : kFar;
}

/// Along a ray, an upright cylinder about the z axis with its lid.
inline double AlongFigure(const Eigen::Vector3d& from, const Eigen::Vector3d& ray) {
  const double a = ray.head<2>().squaredNorm(), b = from.head<2>().dot(ray.head<2>()),
               c = from.head<2>().squaredNorm() - kFigureRadius * kFigureRadius;
  double best = kFar;
  if (const double root = b * b - a * c; root > 0) {
    const double t = (-b - std::sqrt(root)) / a, z = from.z() + t * ray.z();
    if (t > 0 && z > kBookTop && z < kFigureTop) best = t;
  }
  const double lid = (kFigureTop - from.z()) / ray.z();
  if (lid > 0 && (from + lid * ray).head<2>().norm() < kFigureRadius) best = std::min(best, lid);
  return best;
}

/// A cylinder on a book on a table, with a box beside it.
inline Hit Look(const Eigen::Vector3d& from, const Eigen::Vector3d& ray) {
  Hit hit;
  const auto nearer = [&hit](double t, Thing thing) {
    if (t < hit.t) hit = {t, thing};
  };
  if (ray.z() < 0) {
    const double t = -from.z() / ray.z();
    if ((from + t * ray).head<2>().norm() < 2) nearer(t, kTable);
  }
  nearer(AlongBox(from, ray, {-0.2, -0.16, 0}, {0.2, 0.16, kBookTop}), kBook);
  nearer(AlongBox(from, ray, {0.3, 0.05, 0}, {0.42, 0.2, 0.15}), kBox);
  nearer(AlongFigure(from, ray), kFigure);
  return hit;
}

/// Blobs of grey, in space.
inline double Texture(const Eigen::Vector3d& x) {
  double sum = 0;
  for (int k = 1; k <= 3; ++k) {
    const double f = 45.0 * k;
    sum += std::sin(f * x.x() + 3 * k + std::cos(f * 0.7 * x.y())) +
           std::sin(f * 0.9 * x.y() + std::cos(f * 0.8 * x.z())) +
           std::sin(f * 1.1 * x.z() + std::cos(f * 0.6 * x.x()));
  }
  return std::clamp(0.5 + 0.12 * sum, 0.0, 1.0);
}

struct Still {
  std::vector<Image8> images, things;
  Scene scene;
  Eigen::Vector3d middle = {0, 0, 0.15};
};

inline Still MakeStill() {
  constexpr int kViews = 16, kWidth = 240, kHeight = 180;
  Still still;
  still.images.resize(kViews);
  still.things.resize(kViews);
  for (int i = 0; i < kViews; ++i)
    still.scene.views.push_back(MakeTestView(i, kViews, 1.2, 0.7, kWidth, kHeight, 300));
  ParallelFor(kViews, [&](std::int64_t k) {
    const auto v = static_cast<std::size_t>(k);
    const View& view = still.scene.views[v];
    still.images[v] = Image8(kWidth, kHeight, 3, 30);
    still.things[v] = Image8(kWidth, kHeight, 1, kNothing);
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        const Eigen::Vector3d ray =
            view.camera_from_world.rotation.conjugate() * view.camera.Unproject({x + 0.5, y + 0.5});
        const Hit hit = Look(view.Center(), ray);
        *still.things[v].at(x, y) = static_cast<std::uint8_t>(hit.thing);
        if (hit.thing == kNothing) continue;
        const double grey = Texture(view.Center() + hit.t * ray);
        const double tint[][3] = {
            {0, 0, 0}, {1, 1, 0.9}, {0.9, 0.6, 0.7}, {0.6, 0.8, 1}, {0.7, 1, 0.6}};
        for (int c = 0; c < 3; ++c)
          still.images[v].at(x, y)[c] =
              static_cast<std::uint8_t>(30 + 200 * grey * tint[hit.thing][c]);
      }
  });
  return still;
}

class StandingFigureTest : public ::testing::Test {
 protected:
  static const Still& World() {
    static const Still still = MakeStill();
    return still;
  }
  static const CoarseDepths& Depths() {
    static const CoarseDepths depths =
        FindCoarseDepths(World().images, World().scene, World().middle);
    return depths;
  }
  static std::optional<StandingFigure> Standing() {
    return FindStandingFigure(Depths(), World().scene.views, World().middle, {});
  }
};

}  // namespace keypose::capture
