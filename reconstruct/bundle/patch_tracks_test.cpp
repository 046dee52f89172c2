#include "reconstruct/bundle/patch_tracks.h"

#include <gtest/gtest.h>

#include <optional>

#include "core/numbers/parallel.h"
#include "core/values/errors.h"
#include "reconstruct/bundle/testing/textured_ball.h"
#include "reconstruct/testing/known_scenes.h"

namespace keypose::reconstruct::patch_tracks_test {

using Eigen::Vector3d;
using testing::PointsOnBall;

TEST(TrackPatches, PlacesLieWithinAFifthOfAPixelOfTheSurfacePointThatThePatchShows) {
  const Ball ball = MakeBall(18);
  const Scene start = PointsOnBall(ball.views, 500, 0.008);
  const PatchTracks tracks = TrackPatches(start, ball.images, PatchOptions{});
  ASSERT_GT(tracks.observations.size(), 1200U);
  double sum = 0, count = 0, before = 0;
  std::optional<Vector3d> shown;
  int last = -1;
  for (const Observation& o : tracks.observations) {
    // The first position of a point is where its patch was cut.
    const View& view = tracks.scene.views[o.view];
    if (o.point != last) {
      shown = OnBall(view, o.pixel);
      last = o.point;
      continue;
    }
    if (!shown) continue;
    sum += (view.Project(*shown) - o.pixel).norm();
    before += (view.Project(*shown) - view.Project(tracks.scene.points[o.point].position)).norm();
    count += 1;
  }
  EXPECT_LT(sum / count, 0.2);
  EXPECT_GT(before / count, 0.3);  // error of the initial positions
}

TEST(TrackPatches, SameBitsOnOneThreadAndTwo) {
  const Ball ball = MakeBall(8);
  const Scene start = PointsOnBall(ball.views, 200, 0.004);
  SetThreadCount(1);
  const PatchTracks one = TrackPatches(start, ball.images, PatchOptions{});
  SetThreadCount(2);
  const PatchTracks two = TrackPatches(start, ball.images, PatchOptions{});
  SetThreadCount(0);
  ASSERT_EQ(one.observations.size(), two.observations.size());
  for (std::size_t k = 0; k < one.observations.size(); ++k)
    EXPECT_EQ(one.observations[k].pixel, two.observations[k].pixel);
}

TEST(TrackPatches, AsManyPhotographsAsViewsAreAskedFor) {
  Scene scene;
  scene.views.resize(2);
  EXPECT_THROW(TrackPatches(scene, {}, PatchOptions{}), InputError);
}

}  // namespace keypose::reconstruct::patch_tracks_test
