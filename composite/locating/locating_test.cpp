#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "composite/locating/candidates/shape_search.h"
#include "composite/locating/clicks/clicked_place.h"
#include "composite/locating/mattes/mattes.h"
#include "composite/locating/outline/outline_matches.h"
#include "composite/locating/outline/shrunk.h"
#include "composite/locating/refinement/refine.h"
#include "composite/locating/search/locate_shot.h"
#include "core/errors.h"
#include "core/geometry.h"
#include "core/parallel.h"
#include "core/render.h"
#include "core/rotations.h"
#include "core/size_of.h"
#include "core/testing_shapes.h"

namespace keypose::composite {
namespace {

using testing::HasSubstr;

constexpr double kDeg = 3.14159265358979 / 180;

Mesh Joined(const Mesh& a, const Mesh& b) {
  Mesh mesh = a;
  const auto vertices = a.points.rows(), faces = a.faces.rows();
  mesh.points.conservativeResize(vertices + b.points.rows(), 3);
  mesh.points.bottomRows(b.points.rows()) = b.points;
  mesh.faces.conservativeResize(faces + b.faces.rows(), 3);
  mesh.faces.bottomRows(b.faces.rows()) = b.faces.array() + static_cast<int>(vertices);
  return mesh;
}

Mesh BallAt(double x, double y, double z, double radius) {
  Mesh ball = MakeIcosphere(3);
  ball.points = (radius * ball.points).rowwise() + Eigen::RowVector3d(x, y, z);
  return ball;
}

/// A body without any symmetry, about 0.2 high.
Mesh OddBody() {
  Mesh body = BallAt(0, 0, 0.1, 0.07);
  body = Joined(body, BallAt(0.09, 0.01, 0.13, 0.035));
  body = Joined(body, BallAt(0.02, -0.08, 0.05, 0.03));
  return Joined(body, BallAt(-0.03, 0.03, 0.19, 0.028));
}

Camera TestCamera() {
  Camera camera;
  camera.width = 640, camera.height = 480;
  camera.fx = camera.fy = 900, camera.cx = 320, camera.cy = 240;
  return camera;
}

Placement LookingFrom(double azimuth_deg, double elevation_deg, double distance = 0.55) {
  const double a = azimuth_deg * kDeg, e = elevation_deg * kDeg;
  const Eigen::Vector3d eye(distance * std::cos(e) * std::cos(a),
                            distance * std::cos(e) * std::sin(a), 0.1 + distance * std::sin(e));
  return {TestCamera(), LookAt(eye, {0.01, 0, 0.11})};
}

/// Moves the place by some degrees and millimetres.
Placement Disturbed(const Placement& at, double degrees, double shift) {
  Placement moved = at;
  const Eigen::Quaterniond turn = QuaternionOf(Eigen::Vector3d(0.5, -0.7, 0.5) * degrees * kDeg);
  moved.camera_from_mesh.rotation = (turn * at.camera_from_mesh.rotation).normalized();
  moved.camera_from_mesh.translation += Eigen::Vector3d(shift, -shift, 2 * shift);
  return moved;
}

double TurnBetween(const Placement& a, const Placement& b) {
  return AngleOfDifference(
             RotationDifference(a.camera_from_mesh.rotation, b.camera_from_mesh.rotation)) /
         kDeg;
}

/// The largest distance of a vertex between two placements, in pixels.
double ShiftBetween(const Placement& a, const Placement& b, const PointsX3& points) {
  double most = 0;
  for (Eigen::Index v = 0; v < points.rows(); ++v)
    most = std::max(most, (a.Project(points.row(v)) - b.Project(points.row(v))).norm());
  return most;
}

Image8 GreyPicture(const Image8& matte) {
  Image8 picture(matte.width, matte.height, 3, 90);
  for (std::size_t i = 0; i < matte.data.size(); ++i)
    if (matte.data[i] > 127)
      for (int c = 0; c < 3; ++c) picture.data[3 * i + c] = 160;
  return picture;
}

/// A shot of one frame with its exact matte.
ShotInput InputFor(const Mesh& mesh, const Image8& matte) {
  ShotInput input;
  input.mesh = &mesh;
  input.poses = {mesh.points};
  input.camera = TestCamera();
  input.focal_fixed = true, input.solve_k1 = false;
  LocateFrame frame;
  frame.name = "0001.png", frame.picture = GreyPicture(matte), frame.matte = matte;
  input.frames.push_back(std::move(frame));
  return input;
}

TEST(PixelDerivatives, AreThoseOfDifferences) {
  Camera camera = TestCamera();
  camera.k1 = -0.2, camera.k2 = 0.05, camera.p1 = 0.01, camera.p2 = -0.02;
  const Eigen::Vector3d x(0.2, -0.15, 0.9);
  const PixelDerivatives d = DerivativesAt(camera, x);
  constexpr double kStep = 1e-6;
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d move = kStep * Eigen::Vector3d::Unit(i);
    const Eigen::Vector2d difference =
        (camera.Project(x + move) - camera.Project(x - move)) / (2 * kStep);
    EXPECT_LT((d.by_point.col(i) - difference).norm(), 1e-5 * camera.fx);
  }
  Camera longer = camera, bent = camera;
  longer.fx *= 1 + kStep, longer.fy *= 1 + kStep, bent.k1 += kStep;
  EXPECT_LT(((longer.Project(x) - camera.Project(x)) / kStep - d.by_log_focal).norm(), 1e-2);
  EXPECT_LT(((bent.Project(x) - camera.Project(x)) / kStep - d.by_k1).norm(), 1e-2);
}

TEST(NormalEquations, OneStepBringsPointsNearlyHome) {
  const PointsX3 corners = MakeBox(0.1, 0.15, 0.2).points;
  const Placement truth = LookingFrom(30, 20), start = Disturbed(truth, 2, 0.003);
  NormalEquations equations(start, corners.colwise().mean().transpose(), 0.15);
  for (Eigen::Index v = 0; v < corners.rows(); ++v) {
    const Eigen::Vector2d off = truth.Project(corners.row(v)) - start.Project(corners.row(v));
    equations.Add(corners.row(v), Eigen::Vector2d::UnitX(), off.x(), 1);
    equations.Add(corners.row(v), Eigen::Vector2d::UnitY(), off.y(), 1);
  }
  const Placement moved = equations.Moved(equations.Solve(FreeUnknowns(false, false), 0));
  EXPECT_LT(ShiftBetween(moved, truth, corners), 0.05 * ShiftBetween(start, truth, corners));
}

TEST(PlaceByClicks, CubeCornersReprojectToAThousandthOfAPixel) {
  const PointsX3 corners = MakeBox(0.1, 0.1, 0.1).points;
  Placement truth = LookingFrom(40, 25);
  truth.camera.k1 = -0.1;
  std::vector<Click> clicks;
  for (const int v : {0, 1, 2, 5}) {
    SurfacePoint point;
    point.vertices.setConstant(v);
    clicks.push_back({"corner", truth.Project(corners.row(v)), point});
  }
  const Placement found = PlaceByClicks(truth.camera, corners, clicks, false);
  EXPECT_LT(ShiftBetween(found, truth, corners), 1e-3);
}

TEST(PlaceByClicks, SixClicksAlsoGiveTheFocalLength) {
  const PointsX3 corners = MakeBox(0.1, 0.15, 0.2).points;
  const Placement truth = LookingFrom(40, 25, 0.4);
  std::vector<Click> clicks;
  for (int v = 0; v < 8; ++v) {
    SurfacePoint point;
    point.vertices.setConstant(v);
    clicks.push_back({"corner", truth.Project(corners.row(v)), point});
  }
  Camera start = truth.camera;
  start.fx *= 1.3, start.fy *= 1.3;
  const Placement found = PlaceByClicks(start, corners, clicks, true);
  EXPECT_NEAR(found.camera.fx, truth.camera.fx, 0.01);
}

TEST(PlaceByClicks, NamesTheClickThatDoesNotAgree) {
  const PointsX3 corners = MakeBox(0.1, 0.15, 0.2).points;
  const Placement truth = LookingFrom(40, 25);
  std::vector<Click> clicks;
  for (int v = 0; v < 6; ++v) {
    SurfacePoint point;
    point.vertices.setConstant(v);
    clicks.push_back({"click " + std::to_string(v + 1), truth.Project(corners.row(v)), point});
  }
  clicks[3].pixel += Eigen::Vector2d(150, 90);
  try {
    PlaceByClicks(truth.camera, corners, clicks, false);
    FAIL() << "no error";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("click 4"));
  }
}

TEST(PlaceByClicks, ThreeClicksAndClicksOnALineAreRefused) {
  PointsX3 line(4, 3);
  line << 0, 0, 0, 0, 0, 0.1, 0, 0, 0.2, 0, 0, 0.3;
  std::vector<Click> clicks;
  for (int v = 0; v < 4; ++v) {
    SurfacePoint point;
    point.vertices.setConstant(v);
    clicks.push_back({"click", {100.0 + v, 200}, point});
  }
  EXPECT_THROW(PlaceByClicks(TestCamera(), line, clicks, false), InputError);
  clicks.pop_back();
  EXPECT_THROW(PlaceByClicks(TestCamera(), line, clicks, false), InputError);
}

TEST(MatteOutline, OfADiskLiesOnItsCircle) {
  Image8 matte(200, 200, 1);
  for (int y = 0; y < 200; ++y)
    for (int x = 0; x < 200; ++x)
      if (std::hypot(x + 0.5 - 100, y + 0.5 - 100) < 60) *matte.at(x, y) = 255;
  const MatteOutline outline(matte);
  // One point for each pixel of the circle's length, within the quarter that its direction allows.
  EXPECT_NEAR(SizeOf(outline.points()), 2 * 60 * 3.14159, 60);
  double mean = 0;
  for (const OutlinePoint& point : outline.points()) {
    const Eigen::Vector2d from = point.pixel - Eigen::Vector2d(100, 100);
    EXPECT_LT(std::abs(from.norm() - 60), 0.8);
    EXPECT_GT(from.normalized().dot(point.normal), 0.95);
    mean += (from.norm() - 60) / SizeOf(outline.points());
  }
  EXPECT_LT(std::abs(mean), 0.1);
}

TEST(FindSilhouette, OfABallIsItsCircleSeenFromOutside) {
  const Mesh ball = BallAt(0, 0, 0, 0.1);
  const Figure figure(ball.points, ball.faces);
  const Placement at{TestCamera(), LookAt({0.6, 0, 0}, {0, 0, 0})};
  const double radius = 900 * 0.1 / std::sqrt(0.6 * 0.6 - 0.1 * 0.1);
  const std::vector<SilhouettePoint> found = FindSilhouette(figure, at, 2);
  double length = 0;
  for (const SilhouettePoint& point : found) {
    const Eigen::Vector2d from = point.pixel - Eigen::Vector2d(320, 240);
    // The ball is a polyhedron, a little smaller.
    EXPECT_LT(std::abs(from.norm() - radius), 2.5);
    EXPECT_GT(from.normalized().dot(point.normal), 0.9);
    EXPECT_FALSE(point.inner);
    length += point.length_px;
  }
  EXPECT_NEAR(length, 2 * 3.14159 * radius, 0.03 * 2 * 3.14159 * radius);
}

TEST(FindSilhouette, InnerOutlinesAreThoseBeforeOtherParts) {
  const Mesh two = Joined(BallAt(0, 0, 0, 0.1), BallAt(0.3, 0, 0, 0.03));
  const Figure figure(two.points, two.faces);
  const Placement at{TestCamera(), LookAt({0.8, 0, 0}, {0, 0, 0})};
  int inner = 0;
  for (const SilhouettePoint& point : FindSilhouette(figure, at, 2, true)) {
    if (!point.inner) continue;
    ++inner;
    EXPECT_LT((point.pixel - Eigen::Vector2d(320, 240)).norm(), 60);
  }
  EXPECT_GT(inner, 20);
  for (const SilhouettePoint& point : FindSilhouette(figure, at, 2)) EXPECT_FALSE(point.inner);
}

TEST(Shrunk, KeepsTheMeanAndPlainPictures) {
  Image8 picture(7, 5, 1);
  double sum = 0;
  for (std::size_t i = 0; i < picture.data.size(); ++i)
    picture.data[i] = static_cast<std::uint8_t>(7 * i % 256), sum += picture.data[i];
  const Image8 one = Shrunk(picture, 1, 1);
  EXPECT_NEAR(one.data[0], sum / 35, 0.51);
  const Image8 plain = Shrunk(Image8(9, 9, 3, 77), 4, 3);
  for (const std::uint8_t value : plain.data) EXPECT_EQ(value, 77);
}

TEST(ShapeSearch, FindsTheSideThatAMatteShows) {
  const Mesh body = OddBody();
  const Figure figure(body.points, body.faces);
  Placement truth = LookingFrom(70, 15);
  truth.camera = truth.camera.Scaled(0.375);
  const Image8 matte = Covered(figure, truth);
  const ShapeSearch search(figure, AngularRadius(truth.camera, matte));
  const std::vector<ShapeCandidate> found = search.Find(truth.camera, matte, 10);
  ASSERT_FALSE(found.empty());
  EXPECT_LT(TurnBetween({truth.camera, found[0].camera_from_mesh}, truth), 12);
  EXPECT_GT(found[0].overlap, 0.85);
  const Eigen::Vector3d off =
      found[0].camera_from_mesh * figure.center - truth.camera_from_mesh * figure.center;
  EXPECT_LT(off.norm(), 0.05 * 0.55);
  EXPECT_TRUE(search.Find(truth.camera, Image8(240, 180, 1), 10).empty());
}

TEST(Refined, OutlinesBringADisturbedPlaceBack) {
  const Mesh body = OddBody();
  const Figure figure(body.points, body.faces);
  const Placement truth = LookingFrom(-40, 20);
  const Image8 matte = Covered(figure, truth);
  const Evidence evidence = MakeEvidence(GreyPicture(matte), matte, 0.5, 1);
  const Placement found =
      Refined(figure, evidence, Disturbed(truth, 5, 0.004), {40, 3, 15, nullptr, false}, {});
  EXPECT_LT(ShiftBetween(found, truth, body.points), 0.5);
  EXPECT_GT(Overlap(Covered(figure, found), matte), 0.99);
}

TEST(CenterDeviation, FallsWithTheRootOfTheFramesAndIsGreatForAFarFigure) {
  const Mesh body = OddBody();
  const Figure figure(body.points, body.faces);
  const auto deviation_at = [&](double distance, int frames) {
    Placement truth = LookingFrom(-40, 20, distance);
    truth.camera.fx = truth.camera.fy = 900 * distance / 0.55;
    const Image8 matte = Covered(figure, truth);
    const Evidence evidence = MakeEvidence(GreyPicture(matte), matte, 0.5, 1);
    const LensPrior known;  // focal length and distortion are given
    return CenterDeviation(std::vector<SharedFrame>(frames, {&figure, &evidence, truth}), {3, 3, 1},
                           known);
  };
  const double one = deviation_at(0.55, 1);
  EXPECT_GT(one, 0.5);
  EXPECT_NEAR(deviation_at(0.55, 4), one / 2, 0.02 * one);
  EXPECT_GT(deviation_at(2.2, 1), 3 * one) << "a long lens from far away hardly shows it";
}

TEST(ProfileFocal, NearIsKnownAndFarIsNot) {
  const Mesh body = OddBody();
  const Figure figure(body.points, body.faces);
  const auto deviation_at = [&](double distance) {
    Placement truth = LookingFrom(-40, 20, distance);
    truth.camera.fx = truth.camera.fy = 900 * distance / 0.55;
    const Image8 matte = Covered(figure, truth);
    const Evidence evidence = MakeEvidence(GreyPicture(matte), matte, 0.5, 1);
    return ProfileFocal({{&figure, &evidence, truth}}, 6).deviation;
  };
  EXPECT_LT(deviation_at(0.4), 0.05);
  EXPECT_GT(deviation_at(20), 0.1);
}

TEST(LocateShot, FindsTheCameraByTheOutlineAlone) {
  const Mesh body = OddBody();
  const Placement truth = LookingFrom(115, 10);
  const Image8 matte = Covered(Figure(body.points, body.faces), truth);
  const LocatedShot shot = LocateShot(InputFor(body, matte));
  EXPECT_EQ(shot.frames[0].method, "outlines");
  EXPECT_LT(TurnBetween(shot.frames[0].at, truth), 0.5);
  EXPECT_LT(ShiftBetween(shot.frames[0].at, truth, body.points), 1);
  EXPECT_GT(shot.frames[0].iou, 0.99);
  EXPECT_LT(shot.frames[0].contour_px, 0.5);
  EXPECT_EQ(shot.focal, "given");
}

TEST(LocateShot, GivesTheSameBitsWithAnyNumberOfThreads) {
  const Mesh body = OddBody();
  const Image8 matte = Covered(Figure(body.points, body.faces), LookingFrom(10, 30));
  SetThreadCount(1);
  const LocatedShot one = LocateShot(InputFor(body, matte));
  SetThreadCount(3);
  const LocatedShot three = LocateShot(InputFor(body, matte));
  SetThreadCount(0);
  EXPECT_EQ(one.frames[0].at.camera_from_mesh.translation,
            three.frames[0].at.camera_from_mesh.translation);
  EXPECT_EQ(one.frames[0].at.camera_from_mesh.rotation.coeffs(),
            three.frames[0].at.camera_from_mesh.rotation.coeffs());
}

TEST(LocateShot, AStillCameraWithMeshesInOnePlaceDoesNotJitter) {
  const Mesh body = OddBody();
  const Placement truth = LookingFrom(115, 10);
  ShotInput input = InputFor(body, Covered(Figure(body.points, body.faces), truth));
  Mesh moved = body;
  for (Eigen::Index v = 0; v < moved.points.rows(); ++v)
    if (moved.points(v, 0) > 0.06) moved.points(v, 2) += 0.01;  // one ball rises
  input.poses.push_back(moved.points);
  LocateFrame second = input.frames[0];
  second.name = "0002.png", second.pose = 1;
  second.matte = Covered(Figure(moved.points, moved.faces), truth);
  second.picture = GreyPicture(second.matte);
  input.frames.push_back(second);
  const LocatedShot shot = LocateShot(input);
  EXPECT_TRUE(shot.one_place);
  EXPECT_EQ(ShiftBetween(shot.frames[0].at, shot.frames[1].at, body.points), 0);
  EXPECT_LT(ShiftBetween(shot.frames[1].at, truth, body.points), 1);
}

TEST(LocateShot, ACharacterThatIsCarriedGetsAPlaceInEachFrame) {
  const Mesh body = OddBody();
  const Figure figure(body.points, body.faces);
  const Placement truth = LookingFrom(115, 10);
  Placement carried = truth;
  carried.camera_from_mesh.translation.x() += 0.02;
  ShotInput input = InputFor(body, Covered(figure, truth));
  LocateFrame second = input.frames[0];
  second.matte = Covered(figure, carried), second.picture = GreyPicture(second.matte);
  input.frames.push_back(second);
  const LocatedShot shot = LocateShot(input);
  EXPECT_FALSE(shot.one_place);
  EXPECT_LT(ShiftBetween(shot.frames[1].at, carried, body.points), 1);
}

TEST(LocateShot, ClicksOnTheFirstFrameServeAllWithoutMattes) {
  const Mesh body = OddBody();
  const Figure figure(body.points, body.faces);
  const Placement truth = LookingFrom(115, 10);
  Placement carried = truth;
  carried.camera_from_mesh.translation.x() += 0.003;
  ShotInput input = InputFor(body, Covered(figure, truth));
  LocateFrame second = input.frames[0];
  second.picture = GreyPicture(Covered(figure, carried));
  for (const int v : {10, 700, 1400, 2100, 2500}) {
    SurfacePoint point;
    point.vertices.setConstant(v);
    input.frames[0].clicks.push_back({"click", truth.Project(body.points.row(v)), point});
  }
  input.frames.push_back(second);
  for (LocateFrame& frame : input.frames) {
    frame.matte = {};
    for (std::size_t i = 0; i < frame.picture.data.size(); ++i)
      frame.picture.data[i] = static_cast<std::uint8_t>(frame.picture.data[i] + 7 * i % 11);
  }
  const LocatedShot shot = LocateShot(input);
  EXPECT_EQ(shot.frames[0].method, "clicks");
  EXPECT_LT(ShiftBetween(shot.frames[0].at, truth, body.points), 1.5);
  EXPECT_LT(ShiftBetween(shot.frames[1].at, carried, body.points), 1.5);
}

TEST(LocateShot, AVaseAsksForAClickAndTakesIt) {
  const Mesh vase = MakeCylinder(0.05, 0.2, 48, 12);
  const Placement truth = LookingFrom(25, 20);
  ShotInput input = InputFor(vase, Covered(Figure(vase.points, vase.faces), truth));
  try {
    LocateShot(input);
    FAIL() << "no error";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("--clicks"));
  }
  // A vertex of the side that faces the camera.
  int side = 0;
  for (int v = 0; v < vase.vertex_count(); ++v)
    if ((vase.points.row(v) - Eigen::RowVector3d(0.045, 0.02, 0.1)).norm() <
        (vase.points.row(side) - Eigen::RowVector3d(0.045, 0.02, 0.1)).norm())
      side = v;
  SurfacePoint point;
  point.vertices.setConstant(side);
  input.frames[0].clicks = {{"click 1", truth.Project(vase.points.row(side)), point}};
  const LocatedShot shot = LocateShot(input);
  EXPECT_LT(
      (shot.frames[0].at.Project(vase.points.row(side)) - input.frames[0].clicks[0].pixel).norm(),
      2);
}

TEST(LocateShot, AFrameWithoutCharacterIsRefused) {
  const Mesh body = OddBody();
  const Image8 nothing(640, 480, 1);
  try {
    LocateShot(InputFor(body, nothing));
    FAIL() << "no error";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("no character found in 0001.png"));
  }
  ShotInput bare = InputFor(body, nothing);
  bare.frames[0].matte = {};
  EXPECT_THROW(LocateShot(bare), InputError);
}

TEST(MatteFromPlate, LeavesOutShadowsAndFindsNothingInAnEmptySet) {
  Image8 plate(200, 150, 3);
  for (int y = 0; y < 150; ++y)
    for (int x = 0; x < 200; ++x) {
      std::uint8_t* p = plate.at(x, y);
      p[0] = static_cast<std::uint8_t>(100 + x / 4), p[1] = 120,
      p[2] = static_cast<std::uint8_t>(90 + y / 4);
    }
  EXPECT_EQ(MatteShare(MatteFromPlate(plate, plate)), 0);
  Image8 frame = plate;
  for (int y = 40; y < 90; ++y)
    for (int x = 60; x < 120; ++x) {
      std::uint8_t* p = frame.at(x, y);
      p[0] = 200, p[1] = 60, p[2] = 50;
    }
  for (int y = 90; y < 110; ++y)
    for (int x = 60; x < 150; ++x)
      for (int c = 0; c < 3; ++c)
        frame.at(x, y)[c] = static_cast<std::uint8_t>(std::lround(0.75 * plate.at(x, y)[c]));
  const Image8 matte = MatteFromPlate(frame, plate);
  EXPECT_NEAR(MatteShare(matte) * 200 * 150, 50 * 60, 60);
  EXPECT_EQ(*matte.at(90, 65), 255);
  EXPECT_EQ(*matte.at(100, 100), 0);
}

TEST(MatteByColours, FollowsTheFigureWhereTheMeshIsOff) {
  Image8 truth(300, 300, 1), off(300, 300, 1);
  for (int y = 0; y < 300; ++y)
    for (int x = 0; x < 300; ++x) {
      if (std::hypot(x - 150.0, y - 150.0) < 60) *truth.at(x, y) = 255;
      if (std::hypot(x - 154.0, y - 147.0) < 60) *off.at(x, y) = 255;
    }
  Image8 picture(300, 300, 3);
  for (int y = 0; y < 300; ++y)
    for (int x = 0; x < 300; ++x)
      for (int c = 0; c < 3; ++c)
        picture.at(x, y)[c] = static_cast<std::uint8_t>(
            (*truth.at(x, y) ? 170 - 40 * c : 60 + 20 * c) + (7 * x + 13 * y) % 9);
  EXPECT_LT(Overlap(off, truth), 0.93);
  EXPECT_GT(Overlap(MatteByColours(picture, off, 10), truth), 0.98);
}

}  // namespace
}  // namespace keypose::composite
