#include "fit/following/follow.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/shapes.h"
#include "core/values/size_of.h"
#include "fit/testing/breathing_ball.h"

namespace keypose::fit::following_test {

using Eigen::Vector3d;

constexpr int kFrames = BreathingBall::kFrames;
constexpr double kPixel = BreathingBall::kPixel;

TEST(FollowFilms, ASphereBecomesTheBallThatIsFilmed) {
  const BreathingBall world;
  const FollowSource source = world.Source();
  const FollowedMesh followed(world.mesh.points, world.mesh.faces, 2000);
  FollowOptions options;
  options.calm_frames = 0.5;
  const std::vector<Offsets> offsets = FollowFilms(followed, source, nullptr, options);
  const FollowedFrames frames(followed, source, offsets, false);
  for (int f = 0; f < kFrames; ++f) {
    const BentFrame bent = frames.At(f);
    EXPECT_EQ(bent.flipped, 0);
    const double before = world.Error(world.mesh.points, f), after = world.Error(bent.points, f);
    EXPECT_GT(before, 3 * kPixel);
    EXPECT_LT(after, 1.1 * kPixel) << "frame " << f;
    EXPECT_GT(MeanOverlap(bent.points, world.mesh.faces, world.Film(f)), 0.98);
    EXPECT_GT(offsets[f].sure.mean(), 0.3);
  }
}

TEST(FollowFilms, GreyValuesFindWhatOutlinesDoNotShow) {
  const BreathingBall world;
  const FollowedMesh followed(world.mesh.points, world.mesh.faces, 2000);
  const std::vector<PreparedView> views = world.Film(3);
  double errors[2];
  for (const bool grey : {false, true}) {
    const Offsets offsets = FitFrame(followed, world.mesh.points, views, nullptr, {}, {1, grey});
    errors[grey] = world.Error(Bent(followed, world.mesh.points, offsets.local).points, 3);
  }
  EXPECT_LT(errors[1], 0.9 * errors[0]);
}

TEST(FollowFilms, AFineMeshFollowsItsDecimatedCopy) {
  BreathingBall world;
  world.mesh = MakeIcosphere(4);
  const FollowedMesh followed(world.mesh.points, world.mesh.faces, 600);
  EXPECT_LE(followed.coarse_count(), 600);
  const Offsets offsets = FitFrame(followed, world.mesh.points, world.Film(1), nullptr, {}, {});
  const BentFrame bent = Bent(followed, world.mesh.points, offsets.local);
  EXPECT_EQ(bent.flipped, 0);
  EXPECT_LT(world.Error(bent.points, 1), 1.2 * kPixel);
}

TEST(FollowFilms, IsTheSameForAnyThreadCount) {
  const BreathingBall world(3);
  const FollowSource source = world.Source();
  const FollowedMesh followed(world.mesh.points, world.mesh.faces, 300);
  std::vector<PointsX3> results;
  for (const int threads : {1, 3}) {
    SetThreadCount(threads);
    results.push_back(FollowFilms(followed, source, nullptr, {})[2].local);
  }
  SetThreadCount(0);
  EXPECT_EQ(results[0], results[1]);
}

TEST(FollowFilms, AFrameThatNoCameraSawLooksAsThoseAround) {
  const BreathingBall world(4);
  FollowSource source = world.Source();
  const auto filmed = source.views;
  source.views = [&](int first, int count) {
    auto views = filmed(first, count);
    views[2].clear();
    return views;
  };
  const FollowedMesh followed(world.mesh.points, world.mesh.faces, 2000);
  const std::vector<Offsets> offsets = FollowFilms(followed, source, nullptr, {});
  const FollowedFrames frames(followed, source, offsets, false);
  EXPECT_LT(world.Error(frames.At(2).points, 2), 2 * kPixel);
}

TEST(FollowedFrames, KeepTheVolumeInTimeThatTheFilmsAskForInTheMean) {
  const BreathingBall world(3);
  const FollowSource source = world.Source();
  const FollowedMesh followed(world.mesh.points, world.mesh.faces, 2000);
  std::vector<Offsets> offsets;
  for (int f = 0; f < kFrames; ++f)
    offsets.push_back(
        {(0.04 + 0.01 * f) * world.mesh.points, Eigen::VectorXd::Ones(world.mesh.vertex_count())});
  const FollowedFrames frames(followed, source, offsets, true);
  const double at_rest = SignedVolume(world.mesh.points, world.mesh.faces);
  double growth = 0;
  for (int f = 0; f < kFrames; ++f) growth += std::pow(1.04 + 0.01 * f, 3) / kFrames;
  EXPECT_NEAR(frames.volume_ratio(), growth, 1e-9);
  for (int f = 0; f < kFrames; ++f)
    EXPECT_NEAR(SignedVolume(frames.At(f).points, world.mesh.faces) / at_rest,
                frames.volume_ratio(), 1e-6);
}

TEST(FollowedMesh, OffsetsTurnWithTheSurface) {
  const Mesh mesh = MakeCylinder(0.3, 2, 16, 12);
  const FollowedMesh followed(mesh.points, mesh.faces, 5000);
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(2.5, Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  const PointsX3 turned = mesh.points * turn.transpose();
  for (const Eigen::Matrix3d& found : followed.TurnsOf(turned))
    EXPECT_LT((found - turn).norm(), 1e-9);
  const PointsX3 offsets = 0.1 * mesh.points;
  EXPECT_LT((Bent(followed, turned, offsets).points - 1.1 * turned).norm(), 1e-9);
}

TEST(Calmed, KeepsWhatStaysAndFillsWhatIsHidden) {
  std::vector<Offsets> frames(9, {PointsX3::Constant(2, 3, 0.5), Eigen::VectorXd::Ones(2)});
  for (const Offsets& frame : Calmed(frames, 2)) {
    EXPECT_LT((frame.local.array() - 0.5).abs().maxCoeff(), 1e-12);
    EXPECT_NEAR(frame.sure[0], 1, 1e-12);
  }
  frames[4].local.row(1).setConstant(7), frames[4].sure[1] = 0;  // hidden, and wrong there
  const std::vector<Offsets> calmed = Calmed(frames, 0);
  EXPECT_NEAR(calmed[4].local(0, 0), 0.5, 1e-9);
  EXPECT_NEAR(calmed[4].local(1, 0), 0.5, 0.1);
  EXPECT_EQ(calmed[4].sure[1], 0);
}

TEST(Calmed, TakesAwayTheNoiseOfSingleFrames) {
  std::vector<Offsets> frames;
  for (int f = 0; f < 40; ++f)
    frames.push_back({PointsX3::Constant(1, 3, f % 2 ? 1.0 : -1.0), Eigen::VectorXd::Ones(1)});
  for (const Offsets& frame : Calmed(frames, 1.5)) EXPECT_LT(std::abs(frame.local(0, 0)), 0.3);
  EXPECT_TRUE(Calmed({}, 1).empty());
}

}  // namespace keypose::fit::following_test
