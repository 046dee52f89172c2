#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>

#include <Eigen/LU>
#include <cmath>
#include <filesystem>
#include <random>

#include "core/errors.h"
#include "core/parallel.h"
#include "reconstruct/bundle_adjustment.h"
#include "reconstruct/colmap_database.h"
#include "reconstruct/leveling.h"

namespace keypose::reconstruct {
namespace {
namespace fs = std::filesystem;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kPi = 3.14159265358979323846;

class DatabaseTest : public testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (fs::temp_directory_path() / "sfm_test_XXXXXX").string();
    ASSERT_NE(mkdtemp(pattern.data()), nullptr);
    folder = pattern;
    camera.width = 640;
    camera.height = 480;
    camera.fx = camera.fy = 800;
    camera.cx = 320;
    camera.cy = 240;
  }
  void TearDown() override { fs::remove_all(folder); }
  fs::path folder;
  Camera camera;
};

TEST_F(DatabaseTest, VerifiedMatchesAreReadInPairOrderAsTheyWerePut) {
  ColmapDatabase database = ColmapDatabase::Create(folder / "d.db", camera, true, {"a.jpg", "b.jpg", "c.jpg"});
  database.PutInliers({{1, 2, {{0, 3}, {4, 5}}}, {0, 1, {{7, 8}}}, {0, 2, {}}});
  database.PutInliers({{1, 2, {{6, 9}}}});  // in the place of what it had
  const std::vector<PairMatches> pairs = database.VerifiedMatches();
  using Matches = std::vector<std::pair<std::uint32_t, std::uint32_t>>;
  ASSERT_EQ(pairs.size(), 2U);
  EXPECT_EQ(pairs[0].first, 0);
  EXPECT_EQ(pairs[0].second, 1);
  EXPECT_EQ(pairs[0].features, (Matches{{7, 8}}));
  EXPECT_EQ(pairs[1].first, 1);
  EXPECT_EQ(pairs[1].second, 2);
  EXPECT_EQ(pairs[1].features, (Matches{{6, 9}}));
}

TEST_F(DatabaseTest, ImagesWithoutFeaturesReadAsEmpty) {
  EXPECT_EQ(ColmapDatabase::Create(folder / "d.db", camera, true, {"a.jpg"}).ReadFeatures(0).count(), 0);
}

TEST_F(DatabaseTest, MissingFileThrowsDiskError) { EXPECT_THROW(ColmapDatabase(folder / "none.db"), DiskError); }

/// Cameras on rings about +z at 4 units, looking at (0, 0, 0.5), in the frame of truth; points on a blob there.
Scene RingScene(const std::vector<std::pair<double, int>>& rings, double arc, double roll, double noise, std::mt19937& random) {
  Scene scene;
  std::normal_distribution<double> gauss(0, 1);
  Camera camera;
  camera.width = 640, camera.height = 480, camera.fx = camera.fy = 900, camera.cx = 320, camera.cy = 240;
  for (const auto& [elevation, count] : rings)
    for (int i = 0; i < count; ++i) {
      const double azimuth = arc * i / count - kPi / 2;
      const Vector3d target(0, 0, 0.5);
      Vector3d center =
          target + 4 * Vector3d(std::cos(azimuth) * std::cos(elevation), std::sin(azimuth) * std::cos(elevation), std::sin(elevation));
      center += noise * Vector3d(gauss(random), gauss(random), gauss(random));
      const Vector3d forward = (target - center).normalized(), right = forward.cross(Vector3d::UnitZ()).normalized();
      Eigen::Matrix3d rotation;
      rotation << right.transpose(), forward.cross(right).transpose(), forward.transpose();
      rotation = Eigen::AngleAxisd(roll, Vector3d::UnitZ()).toRotationMatrix() * rotation;
      View view;
      view.name = "v" + std::to_string(1000 + scene.views.size());
      view.camera = camera;
      view.camera_from_world.rotation = Eigen::Quaterniond(rotation);
      view.camera_from_world.translation = -(rotation * center);
      scene.views.push_back(view);
    }
  for (int p = 0; p < 400; ++p) {
    SparsePoint point;
    Vector3d direction(gauss(random), gauss(random), gauss(random));
    point.position = Vector3d(0, 0, 0.5) + direction.normalized().cwiseProduct(Vector3d(0.4, 0.3, 0.5));
    point.color << 200, 100, 50;
    scene.points.push_back(point);
  }
  return scene;
}

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

class LevelSceneOn : public testing::TestWithParam<LevelCase> {};

// 0.1 degrees: a tilt that moves the top of a figure by a thousandth of its height and more.
TEST_P(LevelSceneOn, FindsTheAxisWithinATenthOfADegree) {
  std::mt19937 random(21);
  const LevelCase& c = GetParam();
  const Scene truth = RingScene(c.rings, c.arc, c.roll, c.noise, random);
  const Leveling leveling = LevelScene(reconstruct::Transformed(SomeSimilarity(), truth));
  const Similarity3 found = LevelFromTruth(leveling, SomeSimilarity());
  EXPECT_LT(TiltDeg(found), 0.1);
  EXPECT_TRUE(leveling.centered_on_axis);
  const Vector3d axis_foot = found * Vector3d(0, 0, 0);
  EXPECT_LT(axis_foot.head<2>().norm(), 0.005);
}

INSTANTIATE_TEST_SUITE_P(Captures, LevelSceneOn,
                         testing::Values(LevelCase{"one ring", {{0.35, 24}}, 2 * kPi, 0, 0},
                                         LevelCase{"two rings, camera rolled", {{0.2, 16}, {0.7, 16}}, 2 * kPi, 0.3, 0},
                                         LevelCase{"most of a ring", {{0.35, 18}}, 1.3 * kPi, 0.1, 0},
                                         LevelCase{"three noisy rings", {{0.1, 24}, {0.4, 24}, {0.8, 20}}, 2 * kPi, 0.02, 0.004}),
                         [](const auto& c) { return std::to_string(c.index); });

TEST(LevelScene, PutsTheObjectOnTheFloorAndTheFirstCameraInFront) {
  std::mt19937 random(22);
  const Scene model = reconstruct::Transformed(SomeSimilarity(), RingScene({{0.3, 20}}, 2 * kPi, 0, 0, random));
  const Scene level = reconstruct::Transformed(LevelScene(model).level_from_model, model);
  double lowest = 1e9, distance = 0;
  for (const SparsePoint& point : level.points) lowest = std::min(lowest, point.position.z());
  for (const View& view : level.views) distance += (view.Center() - Vector3d(0, 0, 0.125)).norm() / 20;
  EXPECT_NEAR(lowest, 0, 0.01);
  EXPECT_NEAR(distance, 1, 0.02);
  EXPECT_NEAR(level.views[0].Center().x(), 0, 1e-9);
  EXPECT_LT(level.views[0].Center().y(), 0);
  EXPECT_GT(level.views[0].Center().z(), 0.2);
}

TEST(LevelScene, ProjectionsStayWhereTheyAre) {
  std::mt19937 random(23);
  const Scene model = reconstruct::Transformed(SomeSimilarity(), RingScene({{0.3, 20}}, 2 * kPi, 0, 0, random));
  const Scene level = reconstruct::Transformed(LevelScene(model).level_from_model, model);
  for (std::size_t v = 0; v < model.views.size(); v += 3)
    EXPECT_LT((model.views[v].Project(model.points[v].position) - level.views[v].Project(level.points[v].position)).norm(), 1e-7);
}

TEST(LevelScene, TooFewViewsThrow) {
  std::mt19937 random(24);
  Scene scene = RingScene({{0.3, 2}}, 2 * kPi, 0, 0, random);
  EXPECT_THROW(LevelScene(scene), InputError);
  scene = RingScene({{0.3, 5}}, 2 * kPi, 0, 0, random);
  scene.points.resize(3);
  EXPECT_THROW(LevelScene(scene), InputError);
}

struct BundleCase {
  Scene truth, start;
  std::vector<Observation> observations;
};

constexpr BundleOptions kFullCamera{.refine_principal_point = true, .refine_distortion = true, .max_error_px = 4};

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
                                c.truth.views[static_cast<std::size_t>(v)].Project(c.truth.points[static_cast<std::size_t>(p)].position) +
                                    0.2 * Vector2d(gauss(random), gauss(random))});
  for (std::size_t k = 0; k < c.observations.size(); k += 60) c.observations[k].pixel += Vector2d(80, -50);  // wrong matches
  c.start = c.truth;
  for (View& view : c.start.views) {
    view.camera.fx *= 1.02, view.camera.fy *= 1.02;
    view.camera.cx = 320, view.camera.cy = 240;
    view.camera.k1 = view.camera.k2 = view.camera.p1 = view.camera.p2 = 0;
    view.camera_from_world.translation += 0.02 * Vector3d(gauss(random), gauss(random), gauss(random));
  }
  for (SparsePoint& point : c.start.points) point.position += 0.01 * Vector3d(gauss(random), gauss(random), gauss(random));
  return c;
}

PointsX3 Centers(const Scene& scene) {
  PointsX3 centers(static_cast<Eigen::Index>(scene.views.size()), 3);
  for (std::size_t v = 0; v < scene.views.size(); ++v) centers.row(static_cast<Eigen::Index>(v)) = scene.views[v].Center().transpose();
  return centers;
}

// 200 points in 18 views at 0.2 px. The object fills a quarter of the image, so principal point, distortion and poses trade against each
// other by more than they err in together: centres and focal length are what counts. The camera centres follow to well under a thousandth
// of their distance of 4.
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

TEST(AdjustBundle, BadIndicesAndDifferentCamerasThrow) {
  BundleCase c = MakeBundleCase();
  EXPECT_THROW(AdjustBundle(c.start, {{99, 0, Vector2d(0, 0)}}, {}), InputError);
  c.start.views[3].camera.fx += 1;
  EXPECT_THROW(AdjustBundle(c.start, c.observations, {}), InputError);
}

}  // namespace
}  // namespace keypose::reconstruct
