#include "reconstruct/turntable/ring_fit.h"

#include <gtest/gtest.h>

#include <iterator>
#include <random>

#include "reconstruct/testing/known_scenes.h"

namespace keypose::reconstruct::ring_fit_test {

using Eigen::Vector2d;
using Eigen::Vector3d;
using testing::BallCamera;
using testing::PointsOnBall;

struct RingCase {
  Scene truth, start;
  std::vector<Observation> observations;
};

/// Two rings of 12 cameras, or cameras off them by `off_ring`; noisy observations, an inexact
/// start.
RingCase MakeRingCase(double off_ring) {
  std::mt19937 random(2);
  std::normal_distribution<double> normal(0, 1);
  const auto some = [&] { return Vector3d(normal(random), normal(random), normal(random)); };
  RingCase made;
  std::vector<View> views;
  for (int k = 0; k < 24; ++k) {
    views.push_back(BallCamera(k, 12, k < 12 ? 1.5 : 5));
    views.back().camera_from_world.translation += off_ring * some();
  }
  made.truth = PointsOnBall(views, 400, 0);
  made.start = made.truth;
  for (View& view : made.start.views) view.camera_from_world.translation += 0.01 * some();
  for (std::size_t p = 0; p < made.truth.points.size(); ++p)
    for (const int v : made.truth.points[p].views)
      made.observations.push_back({v, static_cast<int>(p),
                                   made.truth.views[v].Project(made.truth.points[p].position) +
                                       Vector2d(0.3 * normal(random), 0.3 * normal(random))});
  return made;
}

double MeanCentreError(const Scene& found, const Scene& truth) {
  PointsX3 a(std::ssize(found.views), 3), b = a;
  for (std::size_t v = 0; v < found.views.size(); ++v) {
    a.row(v) = found.views[v].Center().transpose();
    b.row(v) = truth.views[v].Center().transpose();
  }
  return (Transformed(FitSimilarity(a, b), a) - b).rowwise().norm().mean() /
         b.rowwise().norm().mean();
}

TEST(AdjustOnRings, TurntableIsHeldToItsRingWhichIsNearerToTheTruthThanFreeCameras) {
  const RingCase made = MakeRingCase(0);
  const RingFit fit = AdjustOnRings(made.start, made.observations, RingFitOptions{});
  ASSERT_TRUE(fit.tried);
  EXPECT_TRUE(fit.is_ring) << fit.chi2_ratio;
  BundleOptions square;
  square.keep_aspect = true;
  const double free =
      MeanCentreError(AdjustBundle(made.start, made.observations, square).scene, made.truth);
  EXPECT_LT(MeanCentreError(fit.result.scene, made.truth), 0.4 * free);
  EXPECT_LT(MeanCentreError(fit.result.scene, made.truth), 1.5e-3);
}

TEST(AdjustOnRings, CamerasOffTheRingStayFree) {
  const RingCase made = MakeRingCase(0.02);  // a third of a per cent of their distance
  const RingFit fit = AdjustOnRings(made.start, made.observations, RingFitOptions{});
  EXPECT_FALSE(fit.is_ring) << fit.chi2_ratio;
  EXPECT_LT(MeanCentreError(fit.result.scene, made.truth),
            7e-3);  // uncertainty of free cameras with 0.3 px at this distance from a small body
}

}  // namespace keypose::reconstruct::ring_fit_test
