#include "composite/locating/set/set_cameras.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "composite/locating/set/set_tracks.h"
#include "core/numbers/rotations.h"
#include "core/values/size_of.h"

namespace keypose::composite::set_cameras_test {

const Eigen::Vector3d kCenter(0, 0, 0.1);

Rigid3 CameraAt(const Eigen::Vector3d& place, const Eigen::Vector3d& looks_at) {
  const Eigen::Vector3d z = (looks_at - place).normalized();
  const Eigen::Vector3d x = z.cross(Eigen::Vector3d::UnitZ()).normalized();
  Eigen::Matrix3d turn;
  turn.row(0) = x, turn.row(1) = z.cross(x), turn.row(2) = z;
  return {Eigen::Quaterniond(turn), -turn * place};
}

/// A shot of nine pictures whose camera swings by 8 degrees and comes nearer, before a table and a
/// wall. The start is what a wrong focal length makes of the character alone.
struct Shot {
  Camera camera{960, 540, 1333, 1333, 480, 270, 0, 0, 0, 0};
  std::vector<Rigid3> truth;
  std::vector<Eigen::Vector3d> set, figure;
  SetCameraInput input;
  std::vector<std::vector<Eigen::Vector2d>> figure_pixels;

  Shot(double swing_deg, double dolly, double noise_px, double wrong, int pictures = 9) {
    std::mt19937 random(7);
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> even(-1, 1);
    for (int i = 0; i < 300; ++i) set.emplace_back(0.5 * even(random), 0.5 * even(random), 0);
    for (int i = 0; i < 400; ++i)
      set.emplace_back(0.8 * even(random), 0.6, 0.4 + 0.4 * even(random));
    for (int i = 0; i < 80; ++i)
      figure.push_back(
          kCenter + Eigen::Vector3d(0.05 * even(random), 0.05 * even(random), 0.1 * even(random)));
    for (int i = 0; i < pictures; ++i) {
      const double share = i / (pictures - 1.0), turn = swing_deg * share * M_PI / 180;
      const double away = 0.9 - dolly * share;
      truth.push_back(CameraAt({away * std::sin(turn), -away * std::cos(turn), 0.35}, kCenter));
    }
    input.center = kCenter, input.radius = 0.1;
    for (const Eigen::Vector3d& place : set) {
      SetTrack track;
      for (int i = 0; i < pictures; ++i) {
        const Eigen::Vector2d pixel = camera.Project(truth[i] * place);
        if (pixel.x() < 0 || pixel.y() < 0 || pixel.x() > 960 || pixel.y() > 540) continue;
        track.push_back({i, pixel + noise_px * Eigen::Vector2d(normal(random), normal(random)),
                         Eigen::Matrix2d::Identity() / std::max(0.01, noise_px * noise_px)});
      }
      if (track.size() >= 2) input.tracks.push_back(track);
    }
    for (int i = 0; i < pictures; ++i) {
      figure_pixels.emplace_back();
      for (const Eigen::Vector3d& x : figure)
        figure_pixels[i].push_back(camera.Project(truth[i] * x) +
                                   noise_px * Eigen::Vector2d(normal(random), normal(random)));
    }
    input.pictures = pictures;
    Placement first{camera, truth[0]};
    first.camera.fx *= wrong, first.camera.fy *= wrong;
    first.camera_from_mesh.translation.z() += (wrong - 1) * (truth[0] * kCenter).z();
    LookFrom(first, noise_px);
  }
  /// What the first picture says of the character at a placement.
  void LookFrom(const Placement& first, double noise_px) {
    input.first = first;
    input.character = NormalEquations(first, kCenter, 0.1);
    const double weight = 1 / std::max(1e-2, noise_px * noise_px);
    for (int k = 0; k < SizeOf(figure); ++k) {
      const Eigen::Vector2d off = figure_pixels[0][k] - first.Project(figure[k]);
      input.character.Add(figure[k], Eigen::Vector2d::UnitX(), off.x(), weight);
      input.character.Add(figure[k], Eigen::Vector2d::UnitY(), off.y(), weight);
    }
  }
  /// The equations are linear around a placement, so that it is worth to look again.
  std::optional<SetCameras> Solve(double noise_px) {
    std::optional<SetCameras> found;
    for (int look = 0; look < 3; ++look) {
      found = SolveSetCameras(input);
      if (!found) return {};
      LookFrom(found->cameras[0], noise_px);
    }
    return found;
  }
  /// Mean distance of the character's pixels from where they are.
  double CameraError(const SetCameras& found) const {
    double sum = 0;
    for (int i = 0; i < SizeOf(truth); ++i)
      for (const Eigen::Vector3d& x : figure)
        sum += (found.cameras[i].Project(x) - camera.Project(truth[i] * x)).norm();
    return sum / (SizeOf(truth) * SizeOf(figure));
  }
};

TEST(SetCameras, ExactSightingsGiveTheLensAndTheCamerasBack) {
  Shot shot(8, 0.05, 0, 1.06);
  const auto found = shot.Solve(0);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->cameras[0].camera.fx, 1333, 2);
  EXPECT_LT(shot.CameraError(*found), 0.1);
  EXPECT_LT(found->rms_px, 0.05);  // places of the wall near the table are drawn to it
  EXPECT_GT(found->places, 200);
  for (int i = 0; i < 9; ++i)
    EXPECT_LT((found->cameras[i].camera_from_mesh.Inverse().translation -
               shot.truth[i].Inverse().translation)
                  .norm(),
              1e-3);
}

TEST(SetCameras, NoisySightingsStayWithinTheirOwnUncertainty) {
  Shot shot(8, 0.05, 0.5, 1.06);
  const auto found = shot.Solve(0.5);
  ASSERT_TRUE(found);
  const double off = std::log(found->cameras[0].camera.fx / 1333);
  EXPECT_GT(found->focal_deviation, 0);
  EXPECT_LT(found->focal_deviation, 0.03);
  EXPECT_LT(std::abs(off), 3 * found->focal_deviation);
  EXPECT_LT(shot.CameraError(*found), 0.5);
  EXPECT_NEAR(found->rms_px, 0.5 * std::sqrt(2.0), 0.1);
  EXPECT_GT(found->on_table, 50);
}

TEST(SetCameras, ALongShotIsFollowedToItsEnd) {
  Shot shot(60, 0.1, 0.3, 1, 120);
  const auto found = SolveSetCameras(shot.input);
  ASSERT_TRUE(found);
  EXPECT_LT(shot.CameraError(*found), 1);
}

TEST(SetCameras, WithoutATableTheSizeOfTheSetIsNotKnown) {
  Shot shot(8, 0.05, 0.5, 1);
  std::vector<SetTrack> of_wall;
  for (const SetTrack& track : shot.input.tracks)
    if (track[0].pixel.y() < 170) of_wall.push_back(track);
  ASSERT_GT(of_wall.size(), 40u);
  shot.input.tracks = of_wall;
  EXPECT_FALSE(shot.Solve(0.5));
}

TEST(SetCameras, ABlankSetSaysNothing) {
  Shot shot(8, 0.05, 0.5, 1);
  shot.input.tracks.resize(30);
  EXPECT_FALSE(shot.Solve(0.5));
}

TEST(SetCameras, ACameraThatOnlyTurnsIsFollowed) {
  Shot shot(0, 0, 0.3, 1);
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  shot.input.tracks.clear();
  for (int i = 0; i < 9; ++i)
    shot.truth[i] = Compose(
        {QuaternionOf(Eigen::Vector3d(0, 0.01 * i, 0)), Eigen::Vector3d::Zero()}, shot.truth[0]);
  for (const Eigen::Vector3d& place : shot.set) {
    SetTrack track;
    for (int i = 0; i < 9; ++i)
      track.push_back({i,
                       shot.camera.Project(shot.truth[i] * place) +
                           0.3 * Eigen::Vector2d(normal(random), normal(random)),
                       Eigen::Matrix2d::Identity() / 0.09});
    shot.input.tracks.push_back(track);
  }
  const auto found = shot.Solve(0.3);
  ASSERT_TRUE(found);
  EXPECT_LT(shot.CameraError(*found), 0.5);
  EXPECT_NEAR(found->cameras[0].camera.fx, 1333, 15);
}

}  // namespace keypose::composite::set_cameras_test
