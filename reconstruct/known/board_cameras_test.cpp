// Tests with cameras that are known exactly.
#include "reconstruct/known/board_cameras.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "reconstruct/testing/known_scenes.h"

namespace keypose::reconstruct::board_cameras_test {

using Eigen::Vector2d;
using Eigen::Vector3d;
using ::testing::ElementsAre;
using testing::LookFrom;
using testing::PointAt;

constexpr double kDegree = 3.14159265358979323846 / 180;

Camera TestCamera() {
  Camera camera;
  camera.width = 1440, camera.height = 1080;
  camera.fx = camera.fy = 2400, camera.cx = 720, camera.cy = 540;
  camera.k1 = -0.05;
  return camera;
}

/// Rings of cameras around the board, and their sightings of it.
struct Table {
  std::vector<View> truth;
  std::vector<BoardSighting> sightings;
};

Table MakeTable(const std::vector<double>& elevations_deg, int per_ring, double noise_px) {
  Table table;
  const BoardLayout board;
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0, noise_px);
  for (const double elevation : elevations_deg)
    for (int k = 0; k < per_ring; ++k) {
      const double e = elevation * kDegree, a = 2 * 180 * kDegree * k / per_ring;
      const Vector3d eye =
          0.6 * Vector3d(std::cos(e) * std::cos(a), std::cos(e) * std::sin(a), std::sin(e));
      char name[32];
      std::snprintf(name, sizeof name, "v%03d.jpg", SizeOf(table.truth));
      table.truth.push_back(LookFrom(eye, TestCamera(), name));
      BoardSighting sighting{name, {}};
      for (int id = 0; id < board.CornerCount(); ++id) {
        if (board.Corner(id).norm() < 0.06) continue;  // the figure is there
        sighting.corners.push_back({id, table.truth.back().Project(board.Corner(id)) +
                                            Vector2d(noise(random), noise(random))});
      }
      table.sightings.push_back(sighting);
    }
  return table;
}

double WorstCenter(const Scene& scene, const std::vector<View>& truth) {
  double worst = 0;
  for (std::size_t v = 0; v < scene.views.size(); ++v)
    worst = std::max(worst, (scene.views[v].Center() - truth[v].Center()).norm());
  return worst;
}

/// Every third photograph becomes one of a lens of 0.6 times the size and other distortion.
void TakeWithTwoLenses(Table& table) {
  Camera other = TestCamera().Scaled(0.6);
  other.fx = other.fy = 1000, other.k1 = 0.02;
  for (std::size_t i = 0; i < table.truth.size(); i += 3) {
    View& view = table.truth[i];
    view.camera = other;
    table.sightings[i].lens = 1;
    for (BoardCorner& corner : table.sightings[i].corners)
      corner.pixel = view.Project(BoardLayout{}.Corner(corner.id));
  }
}

TEST(PlaceByBoard, PhotographsOfTwoLensesComeOutExactAndInOrder) {
  Table table = MakeTable({20, 45}, 9, 0);
  TakeWithTwoLenses(table);
  Camera first = TestCamera(), second = TestCamera().Scaled(0.6);
  first.k1 = second.k1 = 0;
  BoardPosesOptions options;
  options.bundle.keep_aspect = true;
  const BoardPoses placed =
      PlaceByBoard({{first, true}, {second, false}}, BoardLayout{}, table.sightings, options);
  ASSERT_EQ(placed.scene.views.size(), 18u);
  EXPECT_LT(placed.rms_px, 1e-3);
  EXPECT_LT(WorstCenter(placed.scene, table.truth), 1e-5);  // of 0.6 m
  EXPECT_NEAR(placed.scene.views[0].camera.fx, 1000, 0.05);
  EXPECT_NEAR(placed.scene.views[1].camera.fx, 2400, 0.05);
  for (const BodyObservation& o : placed.bodies.observations)
    ASSERT_LT((placed.scene.views[o.view].Project(o.on_body) - o.pixel).norm(), 0.01);
}

TEST(PlaceByBoard, ExactCornersGiveTheExactCameras) {
  const Table table = MakeTable({20, 45}, 9, 0);
  Camera start = TestCamera();
  start.k1 = 0;
  BoardPosesOptions options;
  options.bundle.keep_aspect = true;
  const BoardPoses placed = PlaceByBoard(start, true, BoardLayout{}, table.sightings, options);
  ASSERT_EQ(placed.scene.views.size(), 18u);
  EXPECT_LT(placed.rms_px, 1e-3);
  EXPECT_LT(WorstCenter(placed.scene, table.truth), 1e-5);  // of 0.6 m
  EXPECT_NEAR(placed.scene.views[0].camera.fx, 2400, 0.05);
}

TEST(PlaceByBoard, NoisyCornersOfTwoRingsKeepCentresToATenthOfAPercentAndScaleToTwoInTenThousand) {
  const Table table = MakeTable({12, 40}, 18, 0.1);
  BoardPosesOptions options;
  options.bundle.keep_aspect = true;
  const BoardPoses placed =
      PlaceByBoard(TestCamera(), true, BoardLayout{}, table.sightings, options);
  ASSERT_EQ(placed.scene.views.size(), 36u);
  EXPECT_LT(WorstCenter(placed.scene, table.truth), 0.001 * 0.6);
  double mean = 0;
  for (const View& view : placed.scene.views) mean += view.Center().norm() / 36;
  EXPECT_NEAR(mean / 0.6, 1, 2e-4);
}

TEST(PlaceByBoard, UnknownFocalLengthIsFound) {
  const Table table = MakeTable({20, 45}, 9, 0.1);
  Camera start = TestCamera();
  start.fx = start.fy = 1.2 * 1440;
  BoardPosesOptions options;
  options.bundle.keep_aspect = true;
  const BoardPoses placed = PlaceByBoard(start, false, BoardLayout{}, table.sightings, options);
  ASSERT_EQ(placed.scene.views.size(), 18u);
  EXPECT_NEAR(placed.scene.views[0].camera.fx, 2400, 5);
}

TEST(PlaceByBoard, CamerasLieAboveThePlateEvenWhereBothPosesOfThePlaneFit) {
  // From far away a plane's two poses fit equally well, and noise decides; but a print is only seen
  // from above.
  Table table;
  const BoardLayout board;
  Camera camera = TestCamera();
  camera.fx = camera.fy = 24000;
  std::mt19937 random(2);
  std::normal_distribution<double> noise(0, 0.3);
  for (int k = 0; k < 12; ++k) {
    const double a = 30 * kDegree * k, e = 15 * kDegree;
    table.truth.push_back(
        LookFrom(6 * Vector3d(std::cos(e) * std::cos(a), std::cos(e) * std::sin(a), std::sin(e)),
                 camera, "v" + std::to_string(10 + k)));
    BoardSighting sighting{table.truth.back().name, {}};
    for (int id = 0; id < board.CornerCount(); ++id)
      sighting.corners.push_back({id, table.truth.back().Project(board.Corner(id)) +
                                          Vector2d(noise(random), noise(random))});
    table.sightings.push_back(sighting);
  }
  const BoardPoses placed = PlaceByBoard(camera, true, board, table.sightings, {});
  ASSERT_EQ(placed.scene.views.size(), 12u);
  for (const View& view : placed.scene.views) EXPECT_GT(view.Center().z(), 0) << view.name;
}

TEST(PlaceByBoard, ViewWithWrongCornersIsRejectedAndOneWithFewIsCounted) {
  Table table = MakeTable({20, 45}, 9, 0.1);
  std::mt19937 random(9);
  for (BoardCorner& corner : table.sightings[4].corners)
    corner.pixel = Vector2d(random() % 1440, random() % 1080);
  table.sightings[7].corners.resize(5);
  const BoardPoses placed = PlaceByBoard(TestCamera(), true, BoardLayout{}, table.sightings, {});
  EXPECT_EQ(placed.scene.views.size(), 16u);
  EXPECT_THAT(placed.rejected, ElementsAre("v004.jpg"));
  EXPECT_THAT(placed.too_few, ElementsAre("v007.jpg"));
}

TEST(PlaceByBoard, CornerThatThePlateDoesNotHaveThrows) {
  Table table = MakeTable({20}, 4, 0);
  table.sightings[0].corners[0].id = 70;
  EXPECT_THROW(PlaceByBoard(TestCamera(), true, BoardLayout{}, table.sightings, {}), InputError);
}

TEST(AdjustBundle, SecondPlateIsFoundWhereItStands) {
  // Half of the views see the board in the world, half see a copy of it elsewhere; points connect
  // them.
  const BoardLayout board;
  Rigid3 elsewhere;
  elsewhere.rotation = Eigen::AngleAxisd(1.2, Vector3d(1, 2, 0.5).normalized());
  elsewhere.translation = Vector3d(0.02, -0.05, 0.1);
  Table table = MakeTable({25, 50}, 8, 0);
  Scene scene;
  scene.views = table.truth;
  std::mt19937 random(4);
  std::uniform_real_distribution<double> uniform(-0.06, 0.06);
  std::vector<Observation> observations;
  for (int p = 0; p < 200; ++p) {
    scene.points.push_back(
        PointAt(Vector3d(uniform(random), uniform(random), 0.06 + uniform(random))));
    for (int v = 0; v < 16; ++v)
      observations.push_back({v, p, table.truth[v].Project(scene.points.back().position)});
  }
  Bodies bodies;
  bodies.world_from_body = {Rigid3{}, elsewhere};
  for (int v = 0; v < 16; ++v)
    for (int id = 0; id < board.CornerCount(); ++id) {
      const int body = v % 2;
      const Vector3d x = bodies.world_from_body[body] * board.Corner(id);
      bodies.observations.push_back({v, body, board.Corner(id), table.truth[v].Project(x)});
    }
  // Changes everything but the world's board.
  bodies.world_from_body[1].translation += Vector3d(0.002, 0.001, -0.002);
  bodies.world_from_body[1].rotation =
      Eigen::Quaterniond(Eigen::AngleAxisd(0.01, Vector3d::UnitX())) * elsewhere.rotation;
  for (View& view : scene.views)
    view.camera_from_world.translation += Vector3d(0.001 * uniform(random), 0.001, 0.001);
  BundleOptions options;
  options.keep_aspect = true;
  options.max_error_px = 20;
  const BundleResult result = AdjustBundle(scene, observations, options, nullptr, bodies);
  EXPECT_LT(result.bodies_rms_px, 1e-3);
  EXPECT_LT((result.bodies.world_from_body[1].translation - elsewhere.translation).norm(), 1e-6);
  EXPECT_LT(result.bodies.world_from_body[1].rotation.angularDistance(elsewhere.rotation), 1e-6);
  EXPECT_LT(WorstCenter(result.scene, table.truth), 1e-6);
}

}  // namespace keypose::reconstruct::board_cameras_test
