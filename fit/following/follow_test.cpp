#include "fit/following/follow.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"
#include "fit/testing/breathing_ball.h"

namespace keypose::fit::follow_test {

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

}  // namespace keypose::fit::follow_test
