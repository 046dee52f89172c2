#include "capture/room/hidden_parts.h"

#include <gtest/gtest.h>

#include <vector>

#include "capture/room/standing_figure.h"

namespace keypose::capture::hidden_parts_test {

using Eigen::Vector3d;

TEST(HiddenParts, AreWhereSomethingElseIsNearer) {
  // A plate of 0.4 x 0.4, and a smaller one that stands 0.3 before a part of it.
  StandingFigure figure;
  figure.spacing = 0.01;
  for (double x = -0.2; x < 0.2; x += figure.spacing)
    for (double z = 0; z < 0.4; z += figure.spacing) figure.points.emplace_back(x, 0, z);
  for (double x = -0.05; x < 0.1; x += figure.spacing)
    for (double z = 0; z < 0.2; z += figure.spacing) figure.others.emplace_back(x, -0.3, z);
  View view;
  view.camera.width = 640, view.camera.height = 480;
  view.camera.fx = view.camera.fy = 900, view.camera.cx = 320, view.camera.cy = 240;
  Eigen::Matrix3d forward_is_y;
  forward_is_y << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  const Vector3d eye(0, -1.5, 0.2);
  view.camera_from_world = {Eigen::Quaterniond(forward_is_y), -(forward_is_y * eye)};
  View from_behind = view;
  const Eigen::Matrix3d back = Eigen::Vector3d(-1, 1, -1).asDiagonal() * forward_is_y;
  from_behind.camera_from_world = {Eigen::Quaterniond(back), -(back * Vector3d(0, 1.5, 0.2))};
  const std::vector<HiddenPart> parts = HiddenParts({view, from_behind}, figure);
  EXPECT_NEAR(parts[0].share, 0.15 * 1.25 * 0.2 / (0.4 * 0.4), 0.02);
  EXPECT_EQ(parts[1].share, 0);
  const auto hidden = [&](const Vector3d& x) {
    const Eigen::Vector2d pixel = view.Project(x) * parts[0].where.width / view.camera.width;
    return *parts[0].where.at(static_cast<int>(pixel.x()), static_cast<int>(pixel.y())) > 0;
  };
  EXPECT_TRUE(hidden({0.0, 0, 0.1}));
  EXPECT_TRUE(hidden({0.1, 0, 0.05}));
  EXPECT_FALSE(hidden({-0.1, 0, 0.1})) << "beside it";
  EXPECT_FALSE(hidden({0.0, 0, 0.25})) << "above it";
}

}  // namespace keypose::capture::hidden_parts_test
