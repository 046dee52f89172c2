#include "core/surfaces/ray_scene.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <filesystem>
#include <limits>
#include <mutex>
#include <random>
#include <set>
#include <thread>

#include "core/numbers/parallel.h"
#include "core/surfaces/shapes.h"
#include "core/values/errors.h"

namespace keypose::ray_scene_test {

TEST(RayScene, CastHitsTheSphereWhereItMust) {
  const Mesh sphere = MakeIcosphere(4);
  const RayScene scene(sphere.points, sphere.faces);
  const auto hit = scene.Cast({3, 0.01, 0.02}, {-1, 0, 0});
  ASSERT_GE(hit.face, 0);
  EXPECT_NEAR(hit.distance, 2, 5e-3);  // distance of the faces from the sphere
  EXPECT_LT(scene.Cast({3, 0, 2}, {-1, 0, 0}).face, 0);
  EXPECT_TRUE(scene.Occluded({3, 0, 0}, {-1, 0, 0}, 0, 10));
  EXPECT_FALSE(scene.Occluded({3, 0, 0}, {-1, 0, 0}, 0, 1.5));
}

TEST(RayScene, RaysThatAreNotFiniteOrTooLongHitNothing) {
  const Mesh sphere = MakeIcosphere(1);
  const RayScene scene(sphere.points, sphere.faces);
  const Eigen::Vector3d good(3, 0, 0);
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity(), 2e18}) {
    EXPECT_LT(scene.Cast({bad, 0, 0}, {-1, 0, 0}).face, 0);
    EXPECT_LT(scene.Cast(good, {bad, 0, 0}).face, 0);
    EXPECT_FALSE(scene.Occluded({0, bad, 0}, {-1, 0, 0}, 0, 10));
    EXPECT_FALSE(scene.Occluded(good, {-1, bad, 0}, 0, 10));
    EXPECT_LT(scene.ClosestPoint({0, 0, bad}).face, 0);
  }
}

TEST(RayScene, ClosestPointEqualsBruteForce) {
  const Mesh shape = MakeCylinder(0.3, 2, 12, 9);
  const RayScene scene(shape.points, shape.faces);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-1.5, 2.5);
  for (int trial = 0; trial < 20; ++trial) {
    const Eigen::Vector3d p(uniform(random), uniform(random), uniform(random));
    double brute = 1e300;
    for (Eigen::Index f = 0; f < shape.faces.rows(); ++f) {
      const RayScene one(shape.points, FacesX3(shape.faces.row(f)));
      brute = std::min(brute, one.ClosestPoint(p).squared_distance);
    }
    const auto foot = scene.ClosestPoint(p);
    ASSERT_GE(foot.face, 0);
    EXPECT_NEAR(foot.squared_distance, brute, 1e-14);
    EXPECT_NEAR((foot.point - p).squaredNorm(), foot.squared_distance, 1e-12);
  }
}

TEST(RayScene, ClosestPointKeepsToTheRadius) {
  const Mesh sphere = MakeIcosphere(3);
  const RayScene scene(sphere.points, sphere.faces);
  EXPECT_LT(scene.ClosestPoint({3, 0, 0}, 1.9).face, 0);
  EXPECT_GE(scene.ClosestPoint({3, 0, 0}, 2.1).face, 0);
}

TEST(RayScene, LeavesTheLoopsOfTheProcessTheirThreads) {
  const Mesh sphere = MakeIcosphere(2);
  const RayScene scene(sphere.points, sphere.faces);
  SetThreadCount(2);
  std::mutex mutex;
  std::set<std::thread::id> threads;
  for (int round = 0; round < 200 && threads.size() < 2; ++round)
    ParallelFor(64, [&](std::int64_t) {
      std::this_thread::sleep_for(std::chrono::microseconds(200));
      const std::lock_guard lock(mutex);
      threads.insert(std::this_thread::get_id());
    });
  SetThreadCount(0);
  EXPECT_GE(threads.size(), 2u);
}

int ThreadsOfThisProcess() {
  const std::filesystem::directory_iterator tasks("/proc/self/task");
  return static_cast<int>(std::distance(begin(tasks), end(tasks)));
}

/// A second thread could take part in building a tree, and so change which face is hit in a tie.
TEST(RayScene, StartsNoThreadHoweverManyAreMadeAndGone) {
  const Mesh sphere = MakeIcosphere(6);
  const int before = ThreadsOfThisProcess();
  for (int round = 0; round < 5; ++round) {
    const RayScene scene(sphere.points, sphere.faces);
    EXPECT_GE(scene.Cast({3, 0, 0}, {-1, 0, 0}).face, 0);
  }
  EXPECT_EQ(ThreadsOfThisProcess(), before);
}

TEST(RayScene, EmptyMeshThrowsInputError) {
  EXPECT_THROW(RayScene(PointsX3(0, 3), FacesX3(0, 3)), InputError);
}

}  // namespace keypose::ray_scene_test
