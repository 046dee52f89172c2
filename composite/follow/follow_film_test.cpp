#include "composite/follow/follow_film.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "core/surfaces/shapes.h"

namespace keypose::composite::follow_film_test {

/// A ball with a spotted texture before a plain set.
struct SpottedBall {
  Mesh mesh = MakeIcosphere(4);
  View view{"", {240, 180, 260, 260, 120, 90}, LookAt({0, -4, 1}, {0, 0, 0})};
  PixelRays rays{view.camera};
  Character character;
  PointsX3 gains;
  ImageF behind{240, 180, 3, 0.1f};
  Image8 nowhere;

  SpottedBall() {
    character.faces = character.uv_faces = mesh.faces;
    character.uvs.resize(mesh.points.rows(), 2);
    for (Eigen::Index v = 0; v < mesh.points.rows(); ++v)
      character.uvs.row(v) << 0.5 + 0.4 * mesh.points(v, 0), 0.5 + 0.4 * mesh.points(v, 2);
    character.texture = ImageF(128, 128, 3);
    for (int y = 0; y < 128; ++y)
      for (int x = 0; x < 128; ++x)
        for (int c = 0; c < 3; ++c)
          character.texture.at(x, y)[c] =
              static_cast<float>(0.35 + 0.2 * std::sin(0.5 * x + c) * std::cos(0.45 * y));
    gains = PointsX3::Ones(mesh.points.rows(), 3);
  }
  ImageF Filmed(const PointsX3& points) const {
    const ImageF layer =
        RenderLayer(character, points, RayScene(points, mesh.faces), gains, view, rays, 3);
    ImageF light(240, 180, 3);
    for (std::size_t i = 0; i < light.data.size(); ++i)
      light.data[i] = layer.data[i / 3 * 4 + i % 3] + (1 - layer.data[i / 3 * 4 + 3]) * 0.1f;
    return light;
  }
  Followed Follow(const ImageF& filmed) const {
    return FollowFilm({filmed, behind, nowhere, character, gains, view, rays, nullptr, 0},
                      mesh.points);
  }
  /// Mean distance in pixels between points that the camera sees.
  double Off(const PointsX3& a, const PointsX3& b) const {
    double sum = 0, count = 0;
    for (Eigen::Index v = 0; v < a.rows(); ++v) {
      const Eigen::Vector3d x = a.row(v), y = b.row(v);
      if (x.dot(view.Center() - x) < 0.6) continue;
      sum += (view.Project(x) - view.Project(y)).norm(), ++count;
    }
    return sum / count;
  }
};

TEST(FollowFilm, AShiftAndABendOfTheFilmAreFound) {
  const SpottedBall ball;
  PointsX3 moved = ball.mesh.points;
  for (Eigen::Index v = 0; v < moved.rows(); ++v)
    moved(v, 0) += 0.02 + 0.02 * moved(v, 2);  // 1.3 px, and a shear
  const double truth = ball.Off(ball.mesh.points, moved);
  ASSERT_GT(truth, 1);
  const Followed followed = ball.Follow(ball.Filmed(moved));
  EXPECT_LT(ball.Off(ball.mesh.points + followed.shifts, moved), 0.15);
  EXPECT_LT(followed.after, 0.3 * followed.before);
  EXPECT_NEAR(followed.mean_px, truth, 0.4) << "the mean is over other vertices";
  // Nothing moves towards the camera or away.
  const Eigen::Vector3d forward =
      ball.view.camera_from_world.rotation.toRotationMatrix().row(2).transpose();
  EXPECT_LT((followed.shifts * forward).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(FollowFilm, WhatFitsStays) {
  const SpottedBall ball;
  const Followed followed = ball.Follow(ball.Filmed(ball.mesh.points));
  EXPECT_LT(followed.mean_px, 0.03);
}

TEST(FollowFilm, AnotherBrightnessDoesNotBend) {
  const SpottedBall ball;
  ImageF filmed = ball.Filmed(ball.mesh.points);
  for (float& value : filmed.data) value *= 1.1f;
  EXPECT_LT(ball.Follow(filmed).mean_px, 0.3);
}

TEST(FollowFilm, NothingSeenIsNoShift) {
  SpottedBall ball;
  ball.mesh.points.col(0).array() += 50;
  const Followed followed = ball.Follow(ImageF(240, 180, 3, 0.1f));
  EXPECT_EQ(followed.shifts.cwiseAbs().maxCoeff(), 0);
}

}  // namespace keypose::composite::follow_film_test
