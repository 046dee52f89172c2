#include "reconstruct/bundle/bundle_adjustment.h"

#include <gtest/gtest.h>

#include <iterator>
#include <random>

#include "core/numbers/parallel.h"
#include "core/values/errors.h"
#include "reconstruct/testing/known_scenes.h"

namespace keypose::reconstruct::bundle_adjustment_test {

using Eigen::Vector2d;
using Eigen::Vector3d;
using testing::RingScene;

constexpr double kPi = 3.14159265358979323846;

struct BundleCase {
  Scene truth, start;
  std::vector<Observation> observations;
};

constexpr BundleOptions kFullCamera{
    .refine_principal_point = true, .refine_distortion = true, .max_error_px = 4};

BundleCase MakeBundleCase() {
  std::mt19937 random(31);
  std::normal_distribution<double> gauss(0, 1);
  BundleCase c;
  c.truth = RingScene({{0.2, 10}, {0.7, 8}}, 2 * kPi, 0, 0, random);
  for (View& view : c.truth.views) {
    view.camera.cx += 4, view.camera.cy -= 3;
    view.camera.k1 = -0.06, view.camera.k2 = 0.02, view.camera.p1 = 3e-4, view.camera.p2 = -2e-4;
  }
  for (int v = 0; v < 18; ++v)
    for (int p = 0; p < 400; p += 2)
      c.observations.push_back({v, p,
                                c.truth.views[v].Project(c.truth.points[p].position) +
                                    0.2 * Vector2d(gauss(random), gauss(random))});
  for (std::size_t k = 0; k < c.observations.size(); k += 60)
    c.observations[k].pixel += Vector2d(80, -50);  // wrong matches
  c.start = c.truth;
  for (View& view : c.start.views) {
    view.camera.fx *= 1.02, view.camera.fy *= 1.02;
    view.camera.cx = 320, view.camera.cy = 240;
    view.camera.k1 = view.camera.k2 = view.camera.p1 = view.camera.p2 = 0;
    view.camera_from_world.translation +=
        0.02 * Vector3d(gauss(random), gauss(random), gauss(random));
  }
  for (SparsePoint& point : c.start.points)
    point.position += 0.01 * Vector3d(gauss(random), gauss(random), gauss(random));
  return c;
}

PointsX3 Centers(const Scene& scene) {
  PointsX3 centers(std::ssize(scene.views), 3);
  for (std::size_t v = 0; v < scene.views.size(); ++v)
    centers.row(v) = scene.views[v].Center().transpose();
  return centers;
}

// 200 points in 18 views with noise of 0.2 px. The object fills a quarter of the image, so errors
// of principal point, distortion and poses partly cancel: only centres and focal length are tested.
// The camera centres are accurate to well under a thousandth of their distance of 4.
TEST(AdjustBundle, RecoversCamerasDespiteWrongMatches) {
  const BundleCase c = MakeBundleCase();
  const BundleResult result = AdjustBundle(c.start, c.observations, kFullCamera);
  const Similarity3 align = FitSimilarity(Centers(result.scene), Centers(c.truth));
  const PointsX3 moved = keypose::Transformed(align, Centers(result.scene));
  EXPECT_LT((moved - Centers(c.truth)).rowwise().norm().maxCoeff(), 0.004);
  const Camera& found = result.scene.views[0].camera;
  EXPECT_NEAR(found.fx, 900, 3);
  EXPECT_LT(result.after_px, 0.3);
  EXPECT_GE(result.dropped, 55);
  EXPECT_LE(result.dropped, 70);
}

TEST(AdjustBundle, SameBitsForAnyThreadCount) {
  const BundleCase c = MakeBundleCase();
  SetThreadCount(1);
  const BundleResult one = AdjustBundle(c.start, c.observations, {});
  SetThreadCount(4);
  const BundleResult four = AdjustBundle(c.start, c.observations, {});
  SetThreadCount(0);
  EXPECT_EQ(Centers(one.scene), Centers(four.scene));
}

TEST(AdjustBundle, BadIndicesThrow) {
  const BundleCase c = MakeBundleCase();
  EXPECT_THROW(AdjustBundle(c.start, {{99, 0, Vector2d(0, 0)}}, {}), InputError);
}

// Every third view through a lens of half the focal length: the true points of both lenses are
// projected anew, and the adjustment starts 3 % off for both.
TEST(AdjustBundle, TwoLensesAreFoundApart) {
  BundleCase c = MakeBundleCase();
  for (std::size_t v = 0; v < c.truth.views.size(); ++v) {
    if (v % 3 != 0) continue;
    c.truth.views[v].camera.fx = c.truth.views[v].camera.fy = 450;
    c.start.views[v].camera.fx = c.start.views[v].camera.fy = 464;
  }
  for (Observation& o : c.observations)
    o.pixel = c.truth.views[o.view].Project(c.truth.points[o.point].position);
  const BundleResult result = AdjustBundle(c.start, c.observations, kFullCamera);
  EXPECT_NEAR(result.scene.views[0].camera.fx, 450, 1);
  EXPECT_NEAR(result.scene.views[1].camera.fx, c.truth.views[1].camera.fx, 2);
  EXPECT_LT(result.after_px, 0.05);
}

}  // namespace keypose::reconstruct::bundle_adjustment_test
