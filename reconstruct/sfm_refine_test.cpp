// Patches, corners, verification and ring fits on scenes whose truth is known.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/errors.h"
#include "core/parallel.h"
#include "reconstruct/ring_fit.h"
#include "reconstruct/sfm_corners.h"
#include "reconstruct/sfm_patches.h"
#include "reconstruct/sfm_thin.h"
#include "reconstruct/sfm_verification.h"

namespace keypose::reconstruct {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kPi = 3.14159265358979323846;

/// A ball of radius 1 with a texture of waves, and cameras on one ring about z.
struct Ball {
  std::vector<View> views;
  std::vector<PatchImage> images;
};

View RingCamera(int k, int count, double height = 2) {
  const double a = 2 * kPi * k / count;
  const Vector3d center(6 * std::cos(a), 6 * std::sin(a), height), z = -center.normalized(), x = z.cross(Vector3d::UnitZ()).normalized();
  Eigen::Matrix3d r;
  r << x.transpose(), z.cross(x).transpose(), z.transpose();
  View view;
  view.name = std::to_string(100 + k);
  view.camera = {320, 240, 700, 700, 160, 120};
  view.camera_from_world = {Eigen::Quaterniond(r), -(r * center)};
  return view;
}

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
  for (const Eigen::Vector4d& wave : waves) sum += std::sin(28 * wave.head<3>().dot(x) + 3 * wave.w());
  return 128 + 14 * sum;
}

/// Where the ray of a pixel meets the ball.
std::optional<Vector3d> OnBall(const View& view, const Vector2d& pixel) {
  const Vector3d from = view.Center(), along = (view.camera_from_world.rotation.conjugate() * view.camera.Unproject(pixel)).normalized();
  const double b = from.dot(along), root = b * b - from.squaredNorm() + 1;
  if (root < 0) return std::nullopt;
  return Vector3d(from + (-b - std::sqrt(root)) * along);
}

Ball MakeBall(int count) {
  Ball ball;
  ball.images.resize(static_cast<std::size_t>(count));
  for (int k = 0; k < count; ++k) ball.views.push_back(RingCamera(k, count));
  ParallelFor(count, [&](std::int64_t k) {
    const View& view = ball.views[static_cast<std::size_t>(k)];
    Image8 grey(320, 240, 1, 0), mask = grey;
    for (int y = 0; y < 240; ++y)
      for (int x = 0; x < 320; ++x)
        if (const auto at = OnBall(view, Vector2d(x + 0.5, y + 0.5))) {
          *grey.at(x, y) = static_cast<std::uint8_t>(std::clamp(std::lround(Texture(*at)), 0L, 255L));
          *mask.at(x, y) = 255;
        }
    ball.images[static_cast<std::size_t>(k)] = MakePatchImage(grey, mask, 1, PatchOptions{});
  });
  return ball;
}

/// Points spread over the ball, off by `noise`, with the views that see them.
Scene PointsOn(const Ball& ball, int count, double noise) {
  std::mt19937 random(9);
  std::normal_distribution<double> normal(0, noise);
  Scene scene;
  scene.views = ball.views;
  for (int i = 0; i < count; ++i) {
    const double z = 1 - 2 * (i + 0.5) / count, a = 2.399963 * i, r = std::sqrt(1 - z * z);
    const Vector3d on(r * std::cos(a), r * std::sin(a), z);
    SparsePoint point;
    point.position = on + Vector3d(normal(random), normal(random), normal(random));
    point.color.setConstant(0);
    for (std::size_t v = 0; v < scene.views.size(); ++v)
      if (on.dot((scene.views[v].Center() - on).normalized()) > 0.6) point.views.push_back(static_cast<int>(v));
    if (point.views.size() >= 2) scene.points.push_back(point);
  }
  return scene;
}

TEST(TrackPatches, PlacesLieWithinAFifthOfAPixelOfTheSurfacePointThatThePatchShows) {
  const Ball ball = MakeBall(18);
  const Scene start = PointsOn(ball, 500, 0.008);
  const PatchTracks tracks = TrackPatches(start, ball.images, PatchOptions{});
  ASSERT_GT(tracks.observations.size(), 1200U);
  double sum = 0, count = 0, before = 0;
  std::optional<Vector3d> shown;
  int last = -1;
  for (const Observation& o : tracks.observations) {
    // The first place of a point is where its patch was cut.
    const View& view = tracks.scene.views[static_cast<std::size_t>(o.view)];
    if (o.point != last) {
      shown = OnBall(view, o.pixel);
      last = o.point;
      continue;
    }
    if (!shown) continue;
    sum += (view.Project(*shown) - o.pixel).norm();
    before += (view.Project(*shown) - view.Project(tracks.scene.points[static_cast<std::size_t>(o.point)].position)).norm();
    count += 1;
  }
  EXPECT_LT(sum / count, 0.2);
  EXPECT_GT(before / count, 0.3);  // what the start was off by
}

TEST(TrackPatches, SameBitsOnOneThreadAndTwo) {
  const Ball ball = MakeBall(8);
  const Scene start = PointsOn(ball, 200, 0.004);
  SetThreadCount(1);
  const PatchTracks one = TrackPatches(start, ball.images, PatchOptions{});
  SetThreadCount(2);
  const PatchTracks two = TrackPatches(start, ball.images, PatchOptions{});
  SetThreadCount(0);
  ASSERT_EQ(one.observations.size(), two.observations.size());
  for (std::size_t k = 0; k < one.observations.size(); ++k) EXPECT_EQ(one.observations[k].pixel, two.observations[k].pixel);
}

TEST(TrackPatches, AsManyPhotographsAsViewsAreAskedFor) {
  Scene scene;
  scene.views.resize(2);
  EXPECT_THROW(TrackPatches(scene, {}, PatchOptions{}), InputError);
}

TEST(AddCorners, NewPointsLieOnTheSurface) {
  const Ball ball = MakeBall(18);
  Scene start = PointsOn(ball, 300, 0);
  CornerOptions options;
  options.most_points = 900;
  const Scene more = AddCorners(start, ball.images, PatchOptions{}, options);
  ASSERT_GT(more.points.size(), start.points.size() + 200);
  ASSERT_LE(more.points.size(), 900U);
  double off = 0, count = 0;
  for (std::size_t p = start.points.size(); p < more.points.size(); ++p, ++count) off += std::abs(more.points[p].position.norm() - 1);
  EXPECT_LT(off / count, 0.03);  // known points lie 0.2 apart, and planes through six of them 0.02 within the ball
}

TEST(SpreadPoints, KeepsTheCountAndTheObservationsOfWhatItKeeps) {
  const Ball ball{{RingCamera(0, 6), RingCamera(1, 6), RingCamera(2, 6), RingCamera(3, 6), RingCamera(4, 6), RingCamera(5, 6)}, {}};
  const Scene scene = PointsOn(ball, 1000, 0);
  std::vector<Observation> observations;
  for (std::size_t p = 0; p < scene.points.size(); ++p)
    for (const int v : scene.points[p].views)
      observations.push_back({v, static_cast<int>(p), scene.views[static_cast<std::size_t>(v)].Project(scene.points[p].position)});
  const PointSet some = SpreadPoints(scene, observations, 200);
  ASSERT_EQ(some.scene.points.size(), 200U);
  for (const Observation& o : some.observations)
    EXPECT_LT((some.scene.views[static_cast<std::size_t>(o.view)].Project(some.scene.points[static_cast<std::size_t>(o.point)].position) -
               o.pixel)
                  .norm(),
              1e-9);
  EXPECT_EQ(SpreadPoints(scene, observations, 5000).scene.points.size(), scene.points.size());
}

struct RingCase {
  Scene truth, start;
  std::vector<Observation> observations;
};

/// Two rings of 12 cameras, or cameras off them by `off_ring`; observations with noise, a start that is off.
RingCase MakeRingCase(double off_ring) {
  std::mt19937 random(2);
  std::normal_distribution<double> normal(0, 1);
  const auto some = [&] { return Vector3d(normal(random), normal(random), normal(random)); };
  RingCase made;
  Ball ball;
  for (int k = 0; k < 24; ++k) {
    ball.views.push_back(RingCamera(k, 12, k < 12 ? 1.5 : 5));
    ball.views.back().camera_from_world.translation += off_ring * some();
  }
  made.truth = PointsOn(ball, 400, 0);
  made.start = made.truth;
  for (View& view : made.start.views) view.camera_from_world.translation += 0.01 * some();
  for (std::size_t p = 0; p < made.truth.points.size(); ++p)
    for (const int v : made.truth.points[p].views)
      made.observations.push_back({v, static_cast<int>(p),
                                   made.truth.views[static_cast<std::size_t>(v)].Project(made.truth.points[p].position) +
                                       Vector2d(0.3 * normal(random), 0.3 * normal(random))});
  return made;
}

double MeanCentreError(const Scene& found, const Scene& truth) {
  PointsX3 a(static_cast<Eigen::Index>(found.views.size()), 3), b = a;
  for (std::size_t v = 0; v < found.views.size(); ++v) {
    a.row(static_cast<Eigen::Index>(v)) = found.views[v].Center().transpose();
    b.row(static_cast<Eigen::Index>(v)) = truth.views[v].Center().transpose();
  }
  return (Transformed(FitSimilarity(a, b), a) - b).rowwise().norm().mean() / b.rowwise().norm().mean();
}

TEST(AdjustOnRings, TurntableIsHeldToItsRingWhichIsNearerToTheTruthThanFreeCameras) {
  const RingCase made = MakeRingCase(0);
  const RingFit fit = AdjustOnRings(made.start, made.observations, RingFitOptions{});
  ASSERT_TRUE(fit.tried);
  EXPECT_TRUE(fit.is_ring) << fit.chi2_ratio;
  BundleOptions square;
  square.keep_aspect = true;
  const double free = MeanCentreError(AdjustBundle(made.start, made.observations, square).scene, made.truth);
  EXPECT_LT(MeanCentreError(fit.result.scene, made.truth), 0.4 * free);
  EXPECT_LT(MeanCentreError(fit.result.scene, made.truth), 1.5e-3);
}

TEST(AdjustOnRings, CamerasOffTheRingStayFree) {
  const RingCase made = MakeRingCase(0.02);  // a third of a per cent of their distance
  const RingFit fit = AdjustOnRings(made.start, made.observations, RingFitOptions{});
  EXPECT_FALSE(fit.is_ring) << fit.chi2_ratio;
  EXPECT_LT(MeanCentreError(fit.result.scene, made.truth), 7e-3);  // what 0.3 px leave open to free cameras so far from a small body
}

TEST(VerifyPair, InliersOfARigidSceneAreFoundAmongWrongMatchesAndChanceIsNot) {
  const Scene scene = PointsOn({{RingCamera(0, 18), RingCamera(1, 18)}, {}}, 400, 0);
  std::mt19937 random(4);
  std::uniform_real_distribution<float> anywhere(0, 240);
  Features first, second;
  const auto right = static_cast<int>(scene.points.size()), wrong = right;
  for (Features* features : {&first, &second}) {
    features->positions.resize(right + wrong, 2);
    features->scales.setOnes(right + wrong);
    for (int i = 0; i < right + wrong; ++i) {
      const Vector2d pixel = i < right ? scene.views[features == &first ? 0 : 1].Project(scene.points[static_cast<std::size_t>(i)].position)
                                       : Vector2d(anywhere(random), anywhere(random));
      features->positions.row(i) = pixel.cast<float>().transpose();
    }
  }
  PairMatches raw{0, 1, {}}, chance{0, 1, {}};
  for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(right + wrong); ++i) raw.features.emplace_back(i, i);
  for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(std::min(wrong, 60)); ++i)
    chance.features.emplace_back(static_cast<std::uint32_t>(right) + i, static_cast<std::uint32_t>(right) + i);
  VerificationOptions options;
  options.max_error_px = 1;
  const auto verified = VerifyPair(first, second, raw, options);
  ASSERT_TRUE(verified.has_value());
  int found = 0;
  for (const auto& [i, j] : verified->inliers.features) found += static_cast<int>(i) < right ? 1 : 0;
  EXPECT_GT(found, 0.95 * right);
  EXPECT_LT(static_cast<int>(verified->inliers.features.size()) - found, 0.1 * wrong);
  EXPECT_FALSE(VerifyPair(first, second, chance, options).has_value());
  EXPECT_FALSE(VerifyPair(first, second, PairMatches{0, 1, {{0, 0}}}, options).has_value());
}

}  // namespace
}  // namespace keypose::reconstruct
