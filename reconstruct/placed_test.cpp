// Cameras known before features: by the printed plate, from a file, and two models joined. Each against cameras that are known exactly.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/errors.h"
#include "reconstruct/board_poses.h"
#include "reconstruct/flip.h"
#include "reconstruct/known_poses.h"
#include "reconstruct/leveling.h"

namespace keypose::reconstruct {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr double kDegree = 3.14159265358979323846 / 180;

View LookFrom(const Vector3d& eye, const Camera& camera, const std::string& name) {
  const Vector3d z = -eye.normalized(), x = z.cross(Vector3d::UnitZ()).normalized(), y = z.cross(x);
  Eigen::Matrix3d rotation;
  rotation << x.transpose(), y.transpose(), z.transpose();
  View view;
  view.name = name;
  view.camera = camera;
  view.camera_from_world.rotation = rotation;
  view.camera_from_world.translation = -(view.camera_from_world.rotation * eye);
  return view;
}

SparsePoint PointAt(const Vector3d& x) {
  SparsePoint point;
  point.position = x;
  point.color.setZero();
  return point;
}

Camera TestCamera() {
  Camera camera;
  camera.width = 1440, camera.height = 1080;
  camera.fx = camera.fy = 2400, camera.cx = 720, camera.cy = 540;
  camera.k1 = -0.05;
  return camera;
}

/// Rings of cameras round the plate, and what they see of it.
struct Table {
  std::vector<View> truth;
  std::vector<BoardSighting> sightings;
};

Table MakeTable(const std::vector<double>& elevations_deg, int per_ring, double noise_px) {
  Table table;
  const PlateLayout plate;
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0, noise_px);
  for (const double elevation : elevations_deg)
    for (int k = 0; k < per_ring; ++k) {
      const double e = elevation * kDegree, a = 2 * 180 * kDegree * k / per_ring;
      const Vector3d eye = 0.6 * Vector3d(std::cos(e) * std::cos(a), std::cos(e) * std::sin(a), std::sin(e));
      char name[32];
      std::snprintf(name, sizeof name, "v%03d.jpg", static_cast<int>(table.truth.size()));
      table.truth.push_back(LookFrom(eye, TestCamera(), name));
      BoardSighting sighting{name, {}};
      for (int id = 0; id < plate.CornerCount(); ++id) {
        if (plate.Corner(id).norm() < 0.06) continue;  // the figure stands there
        sighting.corners.push_back({id, table.truth.back().Project(plate.Corner(id)) + Vector2d(noise(random), noise(random))});
      }
      table.sightings.push_back(sighting);
    }
  return table;
}

double WorstCenter(const Scene& scene, const std::vector<View>& truth) {
  double worst = 0;
  for (std::size_t v = 0; v < scene.views.size(); ++v) worst = std::max(worst, (scene.views[v].Center() - truth[v].Center()).norm());
  return worst;
}

TEST(PlaceByBoard, ExactCornersGiveTheExactCameras) {
  const Table table = MakeTable({20, 45}, 9, 0);
  Camera start = TestCamera();
  start.k1 = 0;
  BoardPosesOptions options;
  options.bundle.keep_aspect = true;
  const BoardPoses placed = PlaceByBoard(start, true, PlateLayout{}, table.sightings, options);
  ASSERT_EQ(placed.scene.views.size(), 18u);
  EXPECT_LT(placed.rms_px, 1e-3);
  EXPECT_LT(WorstCenter(placed.scene, table.truth), 1e-5);  // of 0.6 m
  EXPECT_NEAR(placed.scene.views[0].camera.fx, 2400, 0.05);
}

TEST(PlaceByBoard, NoisyCornersOfTwoRingsKeepCentresToATenthOfAPercentAndScaleToTwoInTenThousand) {
  const Table table = MakeTable({12, 40}, 18, 0.1);
  BoardPosesOptions options;
  options.bundle.keep_aspect = true;
  const BoardPoses placed = PlaceByBoard(TestCamera(), true, PlateLayout{}, table.sightings, options);
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
  const BoardPoses placed = PlaceByBoard(start, false, PlateLayout{}, table.sightings, options);
  ASSERT_EQ(placed.scene.views.size(), 18u);
  EXPECT_NEAR(placed.scene.views[0].camera.fx, 2400, 5);
}

TEST(PlaceByBoard, CamerasLieAboveThePlateEvenWhereBothPosesOfThePlaneFit) {
  // From far away a plane's two poses fit equally well; noise decides, but a print is seen from above only.
  Table table;
  const PlateLayout plate;
  Camera camera = TestCamera();
  camera.fx = camera.fy = 24000;
  std::mt19937 random(2);
  std::normal_distribution<double> noise(0, 0.3);
  for (int k = 0; k < 12; ++k) {
    const double a = 30 * kDegree * k, e = 15 * kDegree;
    table.truth.push_back(
        LookFrom(6 * Vector3d(std::cos(e) * std::cos(a), std::cos(e) * std::sin(a), std::sin(e)), camera, "v" + std::to_string(10 + k)));
    BoardSighting sighting{table.truth.back().name, {}};
    for (int id = 0; id < plate.CornerCount(); ++id)
      sighting.corners.push_back({id, table.truth.back().Project(plate.Corner(id)) + Vector2d(noise(random), noise(random))});
    table.sightings.push_back(sighting);
  }
  const BoardPoses placed = PlaceByBoard(camera, true, plate, table.sightings, {});
  ASSERT_EQ(placed.scene.views.size(), 12u);
  for (const View& view : placed.scene.views) EXPECT_GT(view.Center().z(), 0) << view.name;
}

TEST(PlaceByBoard, ViewWithWrongCornersIsRejectedAndOneWithFewIsCounted) {
  Table table = MakeTable({20, 45}, 9, 0.1);
  std::mt19937 random(9);
  for (PlateCorner& corner : table.sightings[4].corners) corner.pixel = Vector2d(random() % 1440, random() % 1080);
  table.sightings[7].corners.resize(5);
  const BoardPoses placed = PlaceByBoard(TestCamera(), true, PlateLayout{}, table.sightings, {});
  EXPECT_EQ(placed.scene.views.size(), 16u);
  EXPECT_THAT(placed.rejected, ElementsAre("v004.jpg"));
  EXPECT_THAT(placed.too_few, ElementsAre("v007.jpg"));
}

TEST(PlaceByBoard, CornerThatThePlateDoesNotHaveThrows) {
  Table table = MakeTable({20}, 4, 0);
  table.sightings[0].corners[0].id = 70;
  EXPECT_THROW(PlaceByBoard(TestCamera(), true, PlateLayout{}, table.sightings, {}), InputError);
}

TEST(AdjustBundle, SecondPlateIsFoundWhereItStands) {
  // Half of the views see the plate in the world, half see another copy of it that stands elsewhere; points tie them.
  const PlateLayout plate;
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
    scene.points.push_back(PointAt(Vector3d(uniform(random), uniform(random), 0.06 + uniform(random))));
    for (int v = 0; v < 16; ++v)
      observations.push_back({v, p, table.truth[static_cast<std::size_t>(v)].Project(scene.points.back().position)});
  }
  Bodies bodies;
  bodies.world_from_body = {Rigid3{}, elsewhere};
  for (int v = 0; v < 16; ++v)
    for (int id = 0; id < plate.CornerCount(); ++id) {
      const int body = v % 2;
      const Vector3d x = bodies.world_from_body[static_cast<std::size_t>(body)] * plate.Corner(id);
      bodies.observations.push_back({v, body, plate.Corner(id), table.truth[static_cast<std::size_t>(v)].Project(x)});
    }
  // Disturb everything but the world's plate.
  bodies.world_from_body[1].translation += Vector3d(0.002, 0.001, -0.002);
  bodies.world_from_body[1].rotation = Eigen::Quaterniond(Eigen::AngleAxisd(0.01, Vector3d::UnitX())) * elsewhere.rotation;
  for (View& view : scene.views) view.camera_from_world.translation += Vector3d(0.001 * uniform(random), 0.001, 0.001);
  BundleOptions options;
  options.keep_aspect = true;
  options.max_error_px = 20;
  const BundleResult result = AdjustBundle(scene, observations, options, nullptr, bodies);
  EXPECT_LT(result.bodies_rms_px, 1e-3);
  EXPECT_LT((result.bodies.world_from_body[1].translation - elsewhere.translation).norm(), 1e-6);
  EXPECT_LT(result.bodies.world_from_body[1].rotation.angularDistance(elsewhere.rotation), 1e-6);
  EXPECT_LT(WorstCenter(result.scene, table.truth), 1e-6);
}

/// A cloud and its copy in another frame, with pairs of which a share is wrong.
struct Halves {
  Scene first, second;
  std::vector<std::pair<int, int>> pairs;
  Similarity3 first_from_second;
};

Halves MakeHalves(int good, int wrong) {
  Halves halves;
  halves.first_from_second.scale = 1.7;
  halves.first_from_second.rotation = Eigen::AngleAxisd(1.6, Vector3d(1, -0.3, 0.2).normalized()).toRotationMatrix();
  halves.first_from_second.translation = Vector3d(0.3, -1, 2);
  std::mt19937 random(11);
  std::normal_distribution<double> normal(0, 1);
  const Similarity3 back = halves.first_from_second.Inverse();
  for (int i = 0; i < good + wrong; ++i) {
    const Vector3d x(normal(random), normal(random), normal(random));
    const Vector3d other(normal(random), normal(random), normal(random));
    const Vector3d off = 1e-3 * Vector3d(normal(random), normal(random), normal(random));
    halves.first.points.push_back(PointAt(x));
    halves.second.points.push_back(PointAt(back * (i < good ? x + off : other)));
    halves.pairs.emplace_back(i, i);
  }
  return halves;
}

TEST(JoinModels, FindsTheSimilarityAmongMostlyWrongPairs) {
  const Halves halves = MakeHalves(60, 140);
  const Join join = JoinModels(halves.first, halves.second, halves.pairs, {});
  ASSERT_TRUE(join.found);
  EXPECT_GE(join.agreeing, 60);
  EXPECT_LE(join.agreeing, 62);
  EXPECT_NEAR(join.first_from_second.scale, 1.7, 1e-3);
  EXPECT_LT((join.first_from_second.translation - halves.first_from_second.translation).norm(), 2e-3);
  EXPECT_LT(join.rms, 0.003);
}

TEST(JoinModels, UnrelatedModelsAreNotJoined) {
  const Halves halves = MakeHalves(0, 200);
  EXPECT_FALSE(JoinModels(halves.first, halves.second, halves.pairs, {}).found);
  EXPECT_FALSE(JoinModels(halves.first, halves.second, {}, {}).found);
}

/// Points on a lopsided coloured body: three balls of different sizes, of which `skip` (a direction) leaves one side unseen.
Scene HalfSeen(const Vector3d& skip, const Similarity3& frame, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0, 1);
  const std::vector<std::pair<Vector3d, double>> balls = {{{0, 0, 0}, 0.05}, {{0.02, 0.01, 0.07}, 0.03}, {{0.06, -0.01, 0.01}, 0.02}};
  Scene scene;
  while (scene.points.size() < 3000) {
    const std::size_t b = random() % balls.size();
    const Vector3d normal_out = Vector3d(normal(random), normal(random), normal(random)).normalized();
    if (normal_out.dot(skip) > 0.3) continue;
    SparsePoint point =
        PointAt(frame * Vector3d(balls[b].first + balls[b].second * normal_out + 1e-4 * Vector3d::Constant(normal(random))));
    point.color << static_cast<std::uint8_t>(b == 0 ? 200 : 60), static_cast<std::uint8_t>(b == 1 ? 200 : 60),
        static_cast<std::uint8_t>(b == 2 ? 200 : 60);
    scene.points.push_back(point);
  }
  return scene;
}

TEST(JoinByShape, HalvesThatShareNoFeatureAreTurnedOntoEachOther) {
  Similarity3 lying;
  lying.rotation = Eigen::AngleAxisd(1.7, Vector3d(1, 0.2, 0.1).normalized()).toRotationMatrix();
  lying.translation = Vector3d(0.05, -0.1, 0.04);
  const Scene first = HalfSeen(-Vector3d::UnitZ(), {}, 1), second = HalfSeen(Vector3d::UnitY(), lying, 2);
  const Join join = JoinByShape(first, second, {});
  ASSERT_TRUE(join.found) << join.agreeing << " of " << join.pairs;
  const Similarity3 truth = lying.Inverse();
  EXPECT_LT((join.first_from_second.rotation.transpose() * truth.rotation - Eigen::Matrix3d::Identity()).norm(), 0.02);
  EXPECT_LT((join.first_from_second * Vector3d(0.05, -0.1, 0.1) - truth * Vector3d(0.05, -0.1, 0.1)).norm(), 0.001);
}

TEST(JoinByShape, PlainBallIsNotJoinedSinceAnyTurnFits) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal(0, 1);
  Scene ball;
  for (int i = 0; i < 2000; ++i) ball.points.push_back(PointAt(Vector3d(normal(random), normal(random), normal(random)).normalized()));
  EXPECT_FALSE(JoinByShape(ball, ball, {}).found);
}

/// Masks of some balls, those of that body, from two rings of cameras about an axis in its own frame, seen in another frame.
std::vector<DenseView> BallMasks(const Similarity3& frame, const Vector3d& up,
                                 const std::vector<std::pair<Vector3d, double>>& balls = {
                                     {{0, 0, 0}, 0.05}, {{0.02, 0.01, 0.07}, 0.03}, {{0.06, -0.01, 0.01}, 0.02}}) {
  Camera camera;
  camera.width = 160, camera.height = 120, camera.fx = camera.fy = 300, camera.cx = 80, camera.cy = 60;
  const Eigen::Matrix3d turn = Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), up).toRotationMatrix();
  std::vector<DenseView> views;
  for (int v = 0; v < 16; ++v) {
    const double azimuth = 2 * 3.14159265358979 * v / 8 + 0.3 * (v / 8), elevation = (v < 8 ? 20 : 50) * kDegree;
    const Vector3d eye(0.5 * std::cos(azimuth) * std::cos(elevation), 0.5 * std::sin(azimuth) * std::cos(elevation),
                       0.5 * std::sin(elevation));
    Scene scene;
    scene.views.push_back(LookFrom(eye, camera, "v" + std::to_string(v)));
    scene = Transformed({1, turn, Vector3d(0.02, 0, 0.02)}, scene);
    Image8 mask(camera.width, camera.height, 1, 0);
    const Vector3d center = scene.views[0].Center();
    for (int y = 0; y < camera.height; ++y)
      for (int x = 0; x < camera.width; ++x) {
        const Vector3d ray = (scene.views[0].camera_from_world.rotation.conjugate() * camera.Unproject({x + 0.5, y + 0.5})).normalized();
        for (const auto& [middle, radius] : balls)
          if ((middle - center).cross(ray).norm() < radius) *mask.at(x, y) = 255;
      }
    scene = Transformed(frame, scene);
    views.push_back(PrepareDenseView(scene.views[0], v, Image8(camera.width, camera.height, 3, 128), mask, 1, 1));
  }
  return views;
}

// Neither half is metric: only at the true turn and scale do the points of each half lie within all outlines of the other.
TEST(JoinByOutlines, HalvesWithoutMetresFindTheirScale) {
  Similarity3 lying;
  lying.scale = 1.4;
  lying.rotation = Eigen::AngleAxisd(1.7, Vector3d(1, 0.2, 0.1).normalized()).toRotationMatrix();
  lying.translation = Vector3d(0.05, -0.1, 0.04);
  const Scene first = HalfSeen(-Vector3d::UnitZ(), {}, 1), second = HalfSeen(Vector3d::UnitY(), lying, 2);
  const Silhouettes first_masks(BallMasks({}, Vector3d::UnitZ()), 1), second_masks(BallMasks(lying, -Vector3d::UnitY()), 1);
  const HalfOutlines outlines{first_masks, second_masks};
  OutlineJoinOptions options;
  options.rotations = 120;
  options.coarse_points = 40, options.fine_points = 120;
  options.least_rival_px = 0.4;  // pictures of a third of the size that masks have in the program
  const Join join = JoinByOutlines(first, second, outlines, options);
  ASSERT_TRUE(join.found) << join.agreeing << " of " << join.pairs << ", miss " << join.miss_px << ", rival " << join.rival_miss_px;
  const Similarity3 truth = lying.Inverse();
  EXPECT_NEAR(join.first_from_second.scale / truth.scale, 1, 0.005);
  EXPECT_LT((join.first_from_second.rotation.transpose() * truth.rotation - Eigen::Matrix3d::Identity()).norm(), 0.02);
  // Too large or too small by a twentieth shows in one half's masks or the other's.
  for (const double off : {0.95, 1.05}) {
    Similarity3 wrong = truth;
    wrong.scale *= off, wrong.translation *= off;
    EXPECT_GT(MissedOutlines(first, second, outlines, wrong, 300), 2 * MissedOutlines(first, second, outlines, truth, 300)) << off;
  }
}

TEST(JoinByOutlines, PlainBallIsNotJoinedSinceAnyTurnFits) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal(0, 1);
  Scene ball;
  for (int i = 0; i < 500; ++i)
    ball.points.push_back(PointAt(0.05 * Vector3d(normal(random), normal(random), normal(random)).normalized()));
  const Silhouettes masks(BallMasks({}, Vector3d::UnitZ(), {{Vector3d::Zero(), 0.05}}), 1);
  OutlineJoinOptions options;
  options.rotations = 40;
  options.fine_points = 120;
  options.least_rival_px = 0.4;
  const Join join = JoinByOutlines(ball, ball, {masks, masks}, options);
  EXPECT_FALSE(join.found);
  EXPECT_LT(join.miss_px, 0.5);  // it is the other turns that speak against it
}

TEST(MatchPoints, MostVotesWinAndNoPointIsUsedTwice) {
  // Points 0 and 1 of the first model are seen by image 0 (features 0, 1) and image 1 (features 5, 6); the second's by images 2 and 3.
  const std::vector<TrackElement> first = {{0, 0, 0}, {1, 5, 0}, {0, 1, 1}, {1, 6, 1}}, second = {{2, 7, 0}, {3, 8, 0}, {2, 9, 1}};
  const std::vector<PairMatches> matches = {{0, 2, {{0, 7}, {1, 9}}}, {1, 3, {{5, 8}}}, {1, 2, {{6, 7}}}};
  EXPECT_THAT(MatchPoints(first, second, matches), ElementsAre(std::pair(0, 0), std::pair(1, 1)));
}

TEST(MatchKnownPoses, NamesMatchByStemAndIntrinsicsFollowTheSize) {
  View view = LookFrom({1, 0, 1}, TestCamera(), "images/../b");
  view.name = "b";
  view.camera = TestCamera().Scaled(0.5);
  View shares = LookFrom({0, 1, 1}, Camera{}, "a.png");
  shares.camera.fx = shares.camera.fy = -2400.0 / 1440;
  Camera photograph;
  photograph.width = 1440, photograph.height = 1080;
  const auto matched = MatchKnownPoses({view, shares}, {"a.png", "b.jpg", "c.jpg"}, photograph);
  ASSERT_EQ(matched.size(), 2u);
  EXPECT_EQ(matched[0].name, "a.png");
  EXPECT_NEAR(matched[0].camera.fx, 2400, 1e-9);
  EXPECT_EQ(matched[0].camera.cx, 720);
  EXPECT_EQ(matched[1].name, "b.jpg");
  EXPECT_NEAR(matched[1].camera.fx, 2400, 1e-9);
  EXPECT_EQ(matched[1].camera.width, 1440);
}

std::string MessageOf(const std::function<void()>& act) {
  try {
    act();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(MatchKnownPoses, StrangersTwinsAndOtherShapesAreInputErrors) {
  Camera photograph;
  photograph.width = 1440, photograph.height = 1080;
  const View a = LookFrom({1, 0, 1}, TestCamera(), "a.jpg"), stranger = LookFrom({1, 1, 1}, TestCamera(), "z9.jpg");
  View twin = a, wide = a;
  twin.name = "a";
  wide.camera.width = 1920;
  EXPECT_THAT(MessageOf([&] { MatchKnownPoses({a, stranger}, {"a.jpg"}, photograph); }), HasSubstr("not in the set: z9.jpg"));
  EXPECT_THAT(MessageOf([&] { MatchKnownPoses({a, twin}, {"a.jpg"}, photograph); }), HasSubstr("two cameras for a.jpg"));
  EXPECT_THAT(MessageOf([&] { MatchKnownPoses({wide}, {"a.jpg"}, photograph); }), HasSubstr("1920 x 1080"));
}

}  // namespace
}  // namespace keypose::reconstruct
