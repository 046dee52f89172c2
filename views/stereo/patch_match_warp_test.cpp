#include "views/stereo/patch_match_warp.h"

#include <gtest/gtest.h>

#include <random>

#include "views/stereo/patch_match_cost.h"
#include "views/stereo/patch_match_sweep.h"

namespace keypose::stereo::patch_match_warp_test {

Rigid3 RandomPose(std::mt19937* random) {
  std::uniform_real_distribution<double> unit(-0.2, 0.2);
  Rigid3 pose;
  pose.rotation = Eigen::Quaterniond(1, unit(*random), unit(*random), unit(*random)).normalized();
  pose.translation = Eigen::Vector3d(unit(*random), unit(*random), unit(*random));
  return pose;
}

// H = K_s (R - t n^T / d) K_r^-1 for n^T X + d = 0 maps pixels of plane points, both ways.
TEST(PlaneHypothesis, HomographyMapsPlanePointsBothWays) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(-1, 1);
  const Pinhole r{640, 480, 700, 710, 320.2, 239.1}, s{600, 500, 650, 640, 290, 260};
  for (int trial = 0; trial < 20; ++trial) {
    const Rigid3 s_from_r = RandomPose(&random);
    Eigen::Vector3d corners[3];
    for (Eigen::Vector3d& x : corners)
      x = Eigen::Vector3d(unit(random), unit(random), 4 + unit(random));
    // Inverse depth is linear over the picture: fit it through the three points.
    Eigen::Matrix3d a;
    Eigen::Vector3d w;
    for (int i = 0; i < 3; ++i)
      a.row(i) = r.Project(corners[i]).homogeneous(), w[i] = 1 / corners[i].z();
    const Eigen::Vector3d m = a.inverse() * w;  // (gx, gy, inverse depth at the origin)
    const Eigen::Matrix3d h = s.K() * (s_from_r.rotation.toRotationMatrix() * r.K().inverse() +
                                       s_from_r.translation * m.transpose());
    for (const Eigen::Vector3d& x : corners) {
      const Eigen::Vector3d there = h * r.Project(x).homogeneous(),
                            back = h.inverse() * s.Project(s_from_r * x).homogeneous();
      EXPECT_LT((there.hnormalized() - s.Project(s_from_r * x)).norm(), 1e-9);
      EXPECT_LT((back.hnormalized() - r.Project(x)).norm(), 1e-9);
    }
  }
}

// The lanes that PatchMatch uses, in single precision, against the cameras themselves.
TEST(PlaneHypothesis, LanesFollowTheCamerasAllOverTheWindow) {
  std::mt19937 random(8);
  std::uniform_real_distribution<double> unit(-1, 1);
  PreparedView reference, source;
  reference.levels.resize(1), source.levels.resize(1);
  reference.levels[0].camera = {640, 480, 700, 710, 320.2, 239.1},
  source.levels[0].camera = {600, 500, 650, 640, 290, 260};
  for (int trial = 0; trial < 50; ++trial) {
    source.camera_from_world = RandomPose(&random);
    TransferLanes transfers;
    for (int lane = 0; lane < kLanes; ++lane)
      transfers.Set(lane, MakeTransfer(reference, source, 0));
    const double px = 320 + 200 * unit(random), py = 240 + 150 * unit(random);
    const PlaneHypothesis plane{static_cast<float>(0.25 + 0.05 * unit(random)),
                                static_cast<float>(1e-3 * unit(random)),
                                static_cast<float>(1e-3 * unit(random))};
    for (const float scale : {1.0f, 0.5f}) {
      const WarpLanes warps =
          WarpsOf(transfers, AtPixel(transfers, static_cast<float>(px), static_cast<float>(py)),
                  plane, scale);
      for (int k = 0; k < kPatchSamples; ++k) {
        const double ox = WindowOffsets().dx[k], oy = WindowOffsets().dy[k], dx = scale * ox,
                     dy = scale * oy;
        const Eigen::Vector3d ray =
            reference.camera().Ray(static_cast<float>(px) + dx, static_cast<float>(py) + dy);
        const Eigen::Vector2d expected =
            source.camera().Project(source.camera_from_world *
                                    (ray / (plane.inverse_depth + dx * plane.gx + dy * plane.gy)));
        const double r = 1 / (1 + ox * warps.ex[1] + oy * warps.ey[1]);
        EXPECT_NEAR(warps.x[1] + (ox * warps.ax[1] + oy * warps.bx[1]) * r - 1, expected.x(), 2e-3);
        EXPECT_NEAR(warps.y[1] + (ox * warps.ay[1] + oy * warps.by[1]) * r - 1, expected.y(), 2e-3);
      }
    }
  }
}

TEST(PlaneHypothesis, NormalIsThatOfThePlaneAndFacesTheCamera) {
  const Pinhole camera{640, 480, 700, 710, 320.2, 239.1};
  const Eigen::Vector3d normal = Eigen::Vector3d(0.3, -0.4, -0.8).normalized(), point(0.2, 0.1, 3);
  auto inverse_depth = [&](double x, double y) {
    return normal.dot(camera.Ray(x, y)) / normal.dot(point);
  };
  const PlaneHypothesis plane{
      static_cast<float>(inverse_depth(300, 200)),
      static_cast<float>(inverse_depth(301, 200) - inverse_depth(300, 200)),
      static_cast<float>(inverse_depth(300, 201) - inverse_depth(300, 200))};
  EXPECT_LT((PlaneNormal(camera, 300, 200, plane) - normal).norm(),
            1e-4);  // single precision differences
}

}  // namespace keypose::stereo::patch_match_warp_test
