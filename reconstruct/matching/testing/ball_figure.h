// A figure of balls, its masks from a ring and matches of them.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "core/pictures/fit_view.h"
#include "core/values/angles.h"
#include "core/values/camera.h"
#include "core/values/size_of.h"
#include "reconstruct/matching/colmap_database.h"

namespace keypose::reconstruct {

constexpr int kWidth = 320, kHeight = 240;

struct Ball {
  Eigen::Vector3d center;
  double radius;
};

/// A figure of balls, asymmetric in all directions: trunk, head, arms, a nose, feet.
inline const std::vector<Ball> kFigure = {{{0.02, 0.03, 0}, 0.3},     {{0, 0.05, 0.38}, 0.2},
                                          {{0.34, 0.1, 0.12}, 0.12},  {{-0.42, -0.05, 0.2}, 0.1},
                                          {{0.05, -0.22, 0.4}, 0.08}, {{0.15, -0.1, -0.38}, 0.13},
                                          {{-0.16, 0.08, -0.4}, 0.14}};

inline Scene Ring(int count, double step_deg) {
  Scene scene;
  for (int k = 0; k < count; ++k) {
    const double turn = k * step_deg * kDegree, raised = 20 * kDegree;
    View view;
    view.name = "v" + std::to_string(100 + k);
    view.camera = {.width = kWidth,
                   .height = kHeight,
                   .fx = 500,
                   .fy = 500,
                   .cx = kWidth / 2.0,
                   .cy = kHeight / 2.0};
    view.camera_from_world =
        LookAt(3 * Eigen::Vector3d(std::cos(turn) * std::cos(raised),
                                   std::sin(turn) * std::cos(raised), std::sin(raised)),
               Eigen::Vector3d::Zero());
    scene.views.push_back(view);
  }
  return scene;
}

/// Points on the balls, each a feature of all images, with matches of neighbours.
struct Matched {
  std::vector<Features> features;
  std::vector<PairMatches> pairs;
};

inline Matched MatchesOf(const Scene& truth) {
  std::vector<Eigen::Vector3d> points;
  for (const Ball& ball : kFigure)
    for (int k = 0; k < 10; ++k)
      points.push_back(
          ball.center +
          ball.radius * Eigen::Vector3d(std::cos(k), std::sin(k), std::cos(3.0 * k)).normalized());
  Matched matched;
  for (const View& view : truth.views) {
    Features features;
    features.positions.resize(std::ssize(points), 2);
    features.scales = Eigen::VectorXf::Ones(features.positions.rows());
    for (std::size_t p = 0; p < points.size(); ++p)
      features.positions.row(p) = view.Project(points[p]).transpose().cast<float>();
    matched.features.push_back(std::move(features));
  }
  const int images = SizeOf(truth.views);
  for (int i = 0; i < images; ++i)
    for (int j = i + 1; j < std::min(images, i + 3); ++j) {
      PairMatches pair{i, j, {}};
      for (std::uint32_t p = 0; p < points.size(); ++p) pair.features.emplace_back(p, p);
      matched.pairs.push_back(std::move(pair));
    }
  return matched;
}

}  // namespace keypose::reconstruct
