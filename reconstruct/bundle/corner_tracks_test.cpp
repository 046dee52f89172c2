#include "reconstruct/bundle/corner_tracks.h"

#include <gtest/gtest.h>

#include <cmath>

#include "reconstruct/bundle/patch_tracks.h"
#include "reconstruct/bundle/testing/textured_ball.h"
#include "reconstruct/testing/known_scenes.h"

namespace keypose::reconstruct::corner_tracks_test {

using testing::PointsOnBall;

TEST(AddCorners, NewPointsLieOnTheSurface) {
  const Ball ball = MakeBall(18);
  Scene start = PointsOnBall(ball.views, 300, 0);
  CornerOptions options;
  options.most_points = 900;
  const Scene more = AddCorners(start, ball.images, PatchOptions{}, options);
  ASSERT_GT(more.points.size(), start.points.size() + 200);
  ASSERT_LE(more.points.size(), 900U);
  double off = 0, count = 0;
  for (std::size_t p = start.points.size(); p < more.points.size(); ++p, ++count)
    off += std::abs(more.points[p].position.norm() - 1);
  // Known points have a distance of 0.2, and planes through six of them are up to 0.02 inside the
  // ball.
  EXPECT_LT(off / count, 0.03);
}

}  // namespace keypose::reconstruct::corner_tracks_test
