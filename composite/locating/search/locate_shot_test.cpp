// A shot of one or two frames: by outlines, by clicks, refused.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "composite/locating/search/locate_shot.h"
#include "composite/locating/testing/odd_body.h"
#include "core/numbers/parallel.h"
#include "core/surfaces/shapes.h"
#include "core/values/errors.h"

namespace keypose::composite::locate_shot_test {

using ::testing::HasSubstr;

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

/// A further frame that looks as the first, with its exact matte.
LocateFrame& AddFrame(ShotInput& input, const Image8& matte) {
  LocateFrame frame = input.frames[0];
  frame.name = "0002.png", frame.picture = GreyPicture(matte), frame.matte = matte;
  return input.frames.emplace_back(std::move(frame));
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
  AddFrame(input, Covered(Figure(moved.points, moved.faces), truth)).pose = 1;
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
  AddFrame(input, Covered(figure, carried));
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
  AddFrame(input, Covered(figure, carried));
  for (const int v : {10, 700, 1400, 2100, 2500}) {
    SurfacePoint point;
    point.vertices.setConstant(v);
    input.frames[0].clicks.push_back({"click", truth.Project(body.points.row(v)), point});
  }
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

}  // namespace keypose::composite::locate_shot_test
