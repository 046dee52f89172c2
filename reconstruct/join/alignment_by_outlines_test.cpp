#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/values/angles.h"
#include "reconstruct/join/model_alignment.h"
#include "reconstruct/join/testing/half_seen.h"
#include "reconstruct/testing/known_scenes.h"

namespace keypose::reconstruct::alignment_by_outlines_test {

using Eigen::Vector3d;
using testing::LookFrom;
using testing::PointAt;

/// Masks of some balls, those of that body, from two rings of cameras about an axis in its own
/// frame, seen in another frame.
std::vector<PreparedView> BallMasks(const Similarity3& frame, const Vector3d& up,
                                    const std::vector<std::pair<Vector3d, double>>& balls = {
                                        {{0, 0, 0}, 0.05},
                                        {{0.02, 0.01, 0.07}, 0.03},
                                        {{0.06, -0.01, 0.01}, 0.02}}) {
  Camera camera;
  camera.width = 160, camera.height = 120, camera.fx = camera.fy = 300, camera.cx = 80,
  camera.cy = 60;
  const Eigen::Matrix3d turn =
      Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), up).toRotationMatrix();
  std::vector<PreparedView> views;
  for (int v = 0; v < 16; ++v) {
    const double azimuth = 2 * 3.14159265358979 * v / 8 + 0.3 * (v / 8),
                 elevation = (v < 8 ? 20 : 50) * kDegree;
    const Vector3d eye(0.5 * std::cos(azimuth) * std::cos(elevation),
                       0.5 * std::sin(azimuth) * std::cos(elevation), 0.5 * std::sin(elevation));
    Scene scene;
    scene.views.push_back(LookFrom(eye, camera, "v" + std::to_string(v)));
    scene = Transformed({1, turn, Vector3d(0.02, 0, 0.02)}, scene);
    Image8 mask(camera.width, camera.height, 1, 0);
    const Vector3d center = scene.views[0].Center();
    for (int y = 0; y < camera.height; ++y)
      for (int x = 0; x < camera.width; ++x) {
        const Vector3d ray = (scene.views[0].camera_from_world.rotation.conjugate() *
                              camera.Unproject({x + 0.5, y + 0.5}))
                                 .normalized();
        for (const auto& [middle, radius] : balls)
          if ((middle - center).cross(ray).norm() < radius) *mask.at(x, y) = 255;
      }
    scene = Transformed(frame, scene);
    views.push_back(
        PrepareView(scene.views[0], v, Image8(camera.width, camera.height, 3, 128), mask, 1, 1));
  }
  return views;
}

// Neither model is metric: only with the true rotation and scale do the points of each model
// project inside all outlines of the other.
TEST(AlignByOutlines, HalvesWithoutMetresFindTheirScale) {
  Similarity3 lying;
  lying.scale = 1.4;
  lying.rotation = Eigen::AngleAxisd(1.7, Vector3d(1, 0.2, 0.1).normalized()).toRotationMatrix();
  lying.translation = Vector3d(0.05, -0.1, 0.04);
  const Scene first = HalfSeen(-Vector3d::UnitZ(), {}, 1),
              second = HalfSeen(Vector3d::UnitY(), lying, 2);
  const Silhouettes first_masks(BallMasks({}, Vector3d::UnitZ()), 1),
      second_masks(BallMasks(lying, -Vector3d::UnitY()), 1);
  const HalfOutlines outlines{first_masks, second_masks};
  OutlineAlignmentOptions options;
  options.rotations = 120;
  options.coarse_points = 40, options.fine_points = 120;
  options.least_rival_px = 0.4;  // pictures of a third of the masks' size in the program
  const ModelAlignment join = AlignByOutlines(first, second, outlines, options);
  ASSERT_TRUE(join.found) << join.agreeing << " of " << join.pairs << ", miss " << join.miss_px
                          << ", rival " << join.rival_miss_px;
  const Similarity3 truth = lying.Inverse();
  EXPECT_NEAR(join.first_from_second.scale / truth.scale, 1, 0.005);
  EXPECT_LT(
      (join.first_from_second.rotation.transpose() * truth.rotation - Eigen::Matrix3d::Identity())
          .norm(),
      0.02);
  // An error of scale by a twentieth shows in one model's masks or the other's.
  for (const double off : {0.95, 1.05}) {
    Similarity3 wrong = truth;
    wrong.scale *= off, wrong.translation *= off;
    EXPECT_GT(MissedOutlines(first, second, outlines, wrong, 300),
              2 * MissedOutlines(first, second, outlines, truth, 300))
        << off;
  }
}

TEST(AlignByOutlines, PlainBallIsNotJoinedSinceAnyTurnFits) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal(0, 1);
  Scene ball;
  for (int i = 0; i < 500; ++i)
    ball.points.push_back(
        PointAt(0.05 * Vector3d(normal(random), normal(random), normal(random)).normalized()));
  const Silhouettes masks(BallMasks({}, Vector3d::UnitZ(), {{Vector3d::Zero(), 0.05}}), 1);
  OutlineAlignmentOptions options;
  options.rotations = 40;
  options.fine_points = 120;
  options.least_rival_px = 0.4;
  const ModelAlignment join = AlignByOutlines(ball, ball, {masks, masks}, options);
  EXPECT_FALSE(join.found);
  EXPECT_LT(join.miss_px, 0.5);  // rejected because other rotations fit too
}

}  // namespace keypose::reconstruct::alignment_by_outlines_test
