#include "reconstruct/turntable/leveling.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <random>

#include "core/values/errors.h"
#include "reconstruct/testing/known_scenes.h"

namespace keypose::reconstruct::leveling_test {

using Eigen::Vector2d;
using Eigen::Vector3d;
using testing::RingScene;

constexpr double kPi = 3.14159265358979323846;

Similarity3 SomeSimilarity() {
  Similarity3 s;
  s.scale = 3.7;
  s.rotation = (Eigen::AngleAxisd(1.9, Vector3d(0.3, -0.8, 0.5).normalized())).toRotationMatrix();
  s.translation = Vector3d(5, -2, 9);
  return s;
}

double TiltDeg(const Similarity3& level_from_truth) {
  return std::acos(std::min(1.0, (level_from_truth.rotation * Vector3d::UnitZ()).z())) * 180 / kPi;
}

Similarity3 LevelFromTruth(const Leveling& leveling, const Similarity3& model_from_truth) {
  Similarity3 product;
  product.scale = leveling.level_from_model.scale * model_from_truth.scale;
  product.rotation = leveling.level_from_model.rotation * model_from_truth.rotation;
  product.translation = leveling.level_from_model * model_from_truth.translation;
  return product;
}

struct LevelCase {
  const char* name;
  std::vector<std::pair<double, int>> rings;
  double arc, roll, noise;
};

class LevelSceneOn : public ::testing::TestWithParam<LevelCase> {};

// 0.1 degrees: a larger tilt moves the top of a figure by more than a thousandth of its height.
TEST_P(LevelSceneOn, FindsTheAxisWithinATenthOfADegree) {
  std::mt19937 random(21);
  const LevelCase& c = GetParam();
  const Scene truth = RingScene(c.rings, c.arc, c.roll, c.noise, random);
  const Leveling leveling = LevelScene(Transformed(SomeSimilarity(), truth));
  const Similarity3 found = LevelFromTruth(leveling, SomeSimilarity());
  EXPECT_LT(TiltDeg(found), 0.1);
  EXPECT_TRUE(leveling.centered_on_axis);
  const Vector3d axis_foot = found * Vector3d(0, 0, 0);
  EXPECT_LT(axis_foot.head<2>().norm(), 0.005);
}

INSTANTIATE_TEST_SUITE_P(
    Captures, LevelSceneOn,
    ::testing::Values(
        LevelCase{"one ring", {{0.35, 24}}, 2 * kPi, 0, 0},
        LevelCase{"two rings, camera rolled", {{0.2, 16}, {0.7, 16}}, 2 * kPi, 0.3, 0},
        LevelCase{"most of a ring", {{0.35, 18}}, 1.3 * kPi, 0.1, 0},
        LevelCase{"three noisy rings", {{0.1, 24}, {0.4, 24}, {0.8, 20}}, 2 * kPi, 0.02, 0.004}),
    [](const auto& c) { return std::to_string(c.index); });

TEST(LevelScene, PutsTheObjectOnTheFloorAndTheFirstCameraInFront) {
  std::mt19937 random(22);
  const Scene model = Transformed(SomeSimilarity(), RingScene({{0.3, 20}}, 2 * kPi, 0, 0, random));
  const Scene level = Transformed(LevelScene(model).level_from_model, model);
  double lowest = 1e9, distance = 0;
  for (const SparsePoint& point : level.points) lowest = std::min(lowest, point.position.z());
  for (const View& view : level.views)
    distance += (view.Center() - Vector3d(0, 0, 0.125)).norm() / 20;
  EXPECT_NEAR(lowest, 0, 0.01);
  EXPECT_NEAR(distance, 1, 0.02);
  EXPECT_NEAR(level.views[0].Center().x(), 0, 1e-9);
  EXPECT_LT(level.views[0].Center().y(), 0);
  EXPECT_GT(level.views[0].Center().z(), 0.2);
}

TEST(LevelScene, ProjectionsStayWhereTheyAre) {
  std::mt19937 random(23);
  const Scene model = Transformed(SomeSimilarity(), RingScene({{0.3, 20}}, 2 * kPi, 0, 0, random));
  const Scene level = Transformed(LevelScene(model).level_from_model, model);
  for (std::size_t v = 0; v < model.views.size(); v += 3)
    EXPECT_LT((model.views[v].Project(model.points[v].position) -
               level.views[v].Project(level.points[v].position))
                  .norm(),
              1e-7);
}

TEST(LevelScene, TooFewViewsThrow) {
  std::mt19937 random(24);
  Scene scene = RingScene({{0.3, 2}}, 2 * kPi, 0, 0, random);
  EXPECT_THROW(LevelScene(scene), InputError);
  scene = RingScene({{0.3, 5}}, 2 * kPi, 0, 0, random);
  scene.points.resize(3);
  EXPECT_THROW(LevelScene(scene), InputError);
}

}  // namespace keypose::reconstruct::leveling_test
