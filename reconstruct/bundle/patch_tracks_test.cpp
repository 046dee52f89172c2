#include "reconstruct/bundle/patch_tracks.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <random>

#include "core/numbers/parallel.h"
#include "core/values/errors.h"
#include "reconstruct/bundle/corner_tracks.h"
#include "reconstruct/testing/known_scenes.h"

namespace keypose::reconstruct::patch_tracks_test {

using Eigen::Vector2d;
using Eigen::Vector3d;
using testing::BallCamera;
using testing::PointsOnBall;

/// A ball of radius 1 with a texture of waves, and cameras on one ring about z.
struct Ball {
  std::vector<View> views;
  std::vector<PatchImage> images;
};

double Texture(const Vector3d& x) {
  static const std::vector<Eigen::Vector4d> waves = [] {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> unit(-1, 1);
    std::vector<Eigen::Vector4d> made(16);
    for (Eigen::Vector4d& wave : made)
      for (double& value : wave) value = unit(random);
    return made;
  }();
  double sum = 0;
  for (const Eigen::Vector4d& wave : waves)
    sum += std::sin(28 * wave.head<3>().dot(x) + 3 * wave.w());
  return 128 + 14 * sum;
}

/// Intersection of a pixel's ray with the ball.
std::optional<Vector3d> OnBall(const View& view, const Vector2d& pixel) {
  const Vector3d from = view.Center(), along = (view.camera_from_world.rotation.conjugate() *
                                                view.camera.Unproject(pixel))
                                                   .normalized();
  const double b = from.dot(along), root = b * b - from.squaredNorm() + 1;
  if (root < 0) return std::nullopt;
  return Vector3d(from + (-b - std::sqrt(root)) * along);
}

Ball MakeBall(int count) {
  Ball ball;
  ball.images.resize(static_cast<std::size_t>(count));
  for (int k = 0; k < count; ++k) ball.views.push_back(BallCamera(k, count));
  ParallelFor(count, [&](std::int64_t k) {
    const View& view = ball.views[k];
    Image8 grey(320, 240, 1, 0), mask = grey;
    for (int y = 0; y < 240; ++y)
      for (int x = 0; x < 320; ++x)
        if (const auto at = OnBall(view, Vector2d(x + 0.5, y + 0.5))) {
          *grey.at(x, y) =
              static_cast<std::uint8_t>(std::clamp(std::lround(Texture(*at)), 0L, 255L));
          *mask.at(x, y) = 255;
        }
    ball.images[k] = MakePatchImage(grey, mask, 1, PatchOptions{});
  });
  return ball;
}

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

}  // namespace keypose::reconstruct::patch_tracks_test
