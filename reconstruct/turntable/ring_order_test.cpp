#include "reconstruct/turntable/ring_order.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "core/numbers/parallel.h"
#include "core/values/size_of.h"
#include "reconstruct/turntable/testing/ring_world.h"

namespace keypose::reconstruct::ring_order_test {

using Eigen::Vector3d;

/// Photographs whose names give no order, and the approximate cameras of some of them.
struct Shuffled {
  std::vector<std::string> names;
  std::vector<PairPoints> pairs;
  Scene part;
  std::vector<std::size_t> view_of_image;
};

Shuffled Shuffle(RingWorld& world, const std::vector<std::size_t>& known, double wrong) {
  Shuffled shuffled;
  std::vector<int> image_of_view(world.names.size());
  std::iota(image_of_view.begin(), image_of_view.end(), 0);
  std::shuffle(image_of_view.begin(), image_of_view.end(), world.random);
  shuffled.names = world.names;
  shuffled.view_of_image.resize(world.names.size());
  for (std::size_t v = 0; v < image_of_view.size(); ++v)
    shuffled.view_of_image[image_of_view[v]] = v;
  for (PairPoints& pair : MakePairs(world, 0.5, wrong, 15)) {
    pair.first = image_of_view[pair.first], pair.second = image_of_view[pair.second];
    if (pair.first > pair.second) {
      std::swap(pair.first, pair.second);
      const Eigen::MatrixXd xy = pair.xy;
      pair.xy << xy.rightCols<2>(), xy.leftCols<2>();
    }
    shuffled.pairs.push_back(std::move(pair));
  }
  for (const std::size_t v : known) {
    View view;
    view.name = world.names[image_of_view[v]];
    view.camera = world.truth.camera;
    view.camera_from_world = world.truth.CameraFromTable(world.truth.views[v]);
    view.camera_from_world.translation +=
        0.01 * Vector3d(world.Gauss(1), world.Gauss(1), world.Gauss(1));
    shuffled.part.views.push_back(view);
  }
  for (const Vector3d& x : world.points) {
    SparsePoint point;
    point.position = x;
    point.color.setZero();
    shuffled.part.points.push_back(point);
  }
  return shuffled;
}

/// Photographs whose position in the order is wrong; each ring is counted from its first photograph
/// in its direction of rotation.
int Misplaced(const RingOrder& order, const Shuffled& shuffled, const RingWorld& world) {
  int wrong = 0;
  for (std::size_t r = 0; r < order.layout.rings.size(); ++r) {
    const auto& ring = order.layout.rings[r];
    const auto true_view = [&](std::size_t k) {
      return world.truth.views[shuffled.view_of_image[ring[k].image]];
    };
    int best = 0;
    for (const double sense : {1.0, -1.0}) {
      int right = 0;
      for (std::size_t k = 0; k < ring.size(); ++k) {
        const double turn = 2 * kPi / order.layout.positions[r] * (ring[k].index - ring[0].index),
                     truth = true_view(k).angle_rad - true_view(0).angle_rad;
        right += true_view(k).ring == true_view(0).ring &&
                 std::abs(std::remainder(sense * turn - truth, 2 * kPi)) < 4 * kDegree;
      }
      best = std::max(best, right);
    }
    wrong += SizeOf(ring) - best;
  }
  return wrong;
}

// A mapper that placed nine of 24: the others get positions, and the gaps of five missing ones stay
// gaps.
TEST(OrderOnRings, SortsShuffledPhotographsOfTwoRingsAndKeepsTheGaps) {
  RingWorld world = MakeWorld({12, 40}, 12, 250, 0.6);
  for (const int gone : {22, 17, 11, 6, 5})
    world.truth.views.erase(world.truth.views.begin() + gone), world.names.pop_back();
  for (std::size_t v = 0; v < world.truth.views.size(); ++v)
    world.truth.views[v].image = static_cast<int>(v);
  const Shuffled shuffled = Shuffle(world, {0, 1, 2, 3, 4, 9, 10, 11, 12}, 0.3);
  const auto order = OrderOnRings(shuffled.part, shuffled.names, shuffled.pairs);
  ASSERT_TRUE(order);
  EXPECT_EQ(order->sorted, 19);
  EXPECT_TRUE(order->even);
  EXPECT_THAT(order->layout.positions, ::testing::UnorderedElementsAre(12, 12));
  EXPECT_EQ(Misplaced(*order, shuffled, world), 0);
}

TEST(OrderOnRings, FindsTheRingOfWhichThePartHasNone) {
  RingWorld world = MakeWorld({12, 40}, 12, 250, 0.6);
  const Shuffled shuffled = Shuffle(world, {0, 1, 2, 3, 4, 5, 6}, 0.2);
  SetThreadCount(1);
  const auto order = OrderOnRings(shuffled.part, shuffled.names, shuffled.pairs);
  SetThreadCount(3);
  const auto again = OrderOnRings(shuffled.part, shuffled.names, shuffled.pairs);
  SetThreadCount(0);
  ASSERT_TRUE(order);
  EXPECT_EQ(order->sorted, 24);
  ASSERT_EQ(order->layout.rings.size(), 2U);
  EXPECT_EQ(Misplaced(*order, shuffled, world), 0);
  ASSERT_TRUE(again);
  for (std::size_t r = 0; r < 2; ++r)
    for (std::size_t k = 0; k < order->layout.rings[r].size(); ++k)
      EXPECT_EQ(order->layout.rings[r][k].image, again->layout.rings[r][k].image);
}

TEST(OrderOnRings, MatchesOfNothingSortNothing) {
  RingWorld world = MakeWorld({25}, 16, 100, 0.3);
  const Shuffled shuffled = Shuffle(world, {0, 1, 2, 3, 4, 5}, 1.0);
  EXPECT_FALSE(OrderOnRings(shuffled.part, shuffled.names, shuffled.pairs));
}

}  // namespace keypose::reconstruct::ring_order_test
