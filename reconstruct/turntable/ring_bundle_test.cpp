#include "reconstruct/turntable/ring_bundle.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/values/errors.h"
#include "reconstruct/turntable/testing/ring_world.h"

namespace keypose::reconstruct::ring_bundle_test {

using Eigen::Vector2d;
using Eigen::Vector3d;

struct BundleStart {
  RingModel model;
  std::vector<SparsePoint> points;
  std::vector<Observation> observations;
};

/// Observations of all visible points, and an inexact start.
BundleStart MakeStart(RingWorld& world, double noise) {
  BundleStart start{world.truth, {}, {}};
  for (std::size_t p = 0; p < world.points.size(); ++p) {
    SparsePoint point;
    point.position =
        world.points[p] + 0.02 * Vector3d(world.Gauss(1), world.Gauss(1), world.Gauss(1));
    point.color.setZero();
    start.points.push_back(point);
    for (std::size_t v = 0; v < world.truth.views.size(); ++v)
      if (world.Sees(v, p))
        start.observations.push_back(
            {static_cast<int>(v), static_cast<int>(p), world.Pixel(v, p, noise)});
  }
  for (RingView& view : start.model.views)
    view.angle_rad = view.index * world.truth.step_rad[view.ring];
  for (Rigid3& ring : start.model.rings) {
    ring.rotation = ring.rotation * Eigen::Quaterniond(Eigen::AngleAxisd(
                                        0.01, Vector3d(0.3, 0.8, 0.5).normalized()));
    ring.translation += Vector3d(0.02, -0.03, 0.05);
  }
  start.model.camera.fx = start.model.camera.fy = 1.02 * world.truth.camera.fx;
  return start;
}

// The known answer of a rendered ring: 0.3 px of noise, centres accurate to a thousandth of the
// radius, and a table that stops 0.2 degrees off its marks, estimated to a tenth of that. 1,000
// points, each seen by some nine views; a photograph of clay has more.
TEST(AdjustRingBundle, RecoversCentersToAThousandthAndSlopToATenthOfIt) {
  RingWorld world = MakeWorld({25}, 24, 1000, 0.2);
  const BundleStart start = MakeStart(world, 0.3);
  const RingBundleResult result =
      AdjustRingBundle(start.model, start.points, start.observations, {});
  EXPECT_LT(CenterError(Centers(result.model), Centers(world.truth)), 1e-3);
  EXPECT_LT(result.mean_error_px,
            0.45);  // the mean length of a 2D error of 0.3 px each way is 0.376
  // Angles are known up to a common rotation, which changes nothing.
  double turn = 0;
  for (std::size_t v = 0; v < 24; ++v)
    turn += (result.model.views[v].angle_rad - world.truth.views[v].angle_rad) / 24;
  for (std::size_t v = 0; v < 24; ++v)
    EXPECT_NEAR(result.model.views[v].angle_rad - turn, world.truth.views[v].angle_rad,
                0.02 * kDegree)
        << v;
}

// 25 tracks in all: too few for poses of six unknowns each, enough for a ring.
TEST(AdjustRingBundle, TwentyFiveTracksHoldARing) {
  RingWorld world = MakeWorld({25}, 24, 25, 0.2);
  const BundleStart start = MakeStart(world, 0.3);
  const RingBundleResult result =
      AdjustRingBundle(start.model, start.points, start.observations, {});
  EXPECT_LT(CenterError(Centers(result.model), Centers(world.truth)), 3e-3);
  EXPECT_LT(result.unknowns, 24 + 12);
}

TEST(AdjustRingBundle, BadIndicesThrow) {
  RingWorld world = MakeWorld({25}, 8, 20, 0);
  BundleStart start = MakeStart(world, 0);
  EXPECT_THROW(AdjustRingBundle(start.model, start.points, {{8, 0, Vector2d::Zero()}}, {}),
               InputError);
  start.model.views[2].ring = 1;
  EXPECT_THROW(AdjustRingBundle(start.model, start.points, start.observations, {}), InputError);
}

}  // namespace keypose::reconstruct::ring_bundle_test
