#include "fit/following/frame_fit.h"

#include <gtest/gtest.h>

#include "core/surfaces/shapes.h"
#include "fit/following/follow.h"
#include "fit/testing/breathing_ball.h"

namespace keypose::fit::frame_fit_test {

constexpr double kPixel = BreathingBall::kPixel;

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

}  // namespace keypose::fit::frame_fit_test
