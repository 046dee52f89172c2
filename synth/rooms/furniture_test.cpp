#include "synth/rooms/furniture.h"

#include <gtest/gtest.h>

#include "synth/rooms/canvas.h"
#include "synth/rooms/print.h"

namespace keypose::synth::furniture_test {

using Eigen::Vector3d;

// A box of 2 x 4 x 6 cm whose front is white on the right half.
TEST(Furniture, BoxesFaceOutwardsAndCarryTheirPrintsUpright) {
  Furniture box;
  Image8 halves(2, 1, 3);
  for (int c = 0; c < 3; ++c) halves.at(1, 0)[c] = 255;
  const int print = box.AddPrint(Print(halves, 0.02));
  box.AddBox({Eigen::Quaterniond::Identity(), {0, 0, 0.03}}, {0.02, 0.04, 0.06},
             {print, print, print, print, print, print}, Part::kThing);
  box.Finish();
  const Mesh mesh = box.AsMesh();
  double volume = 0;
  for (Eigen::Index f = 0; f < mesh.faces.rows(); ++f)
    volume += Vector3d(mesh.points.row(mesh.faces(f, 0)))
                  .dot(Vector3d(mesh.points.row(mesh.faces(f, 1)))
                           .cross(Vector3d(mesh.points.row(mesh.faces(f, 2))))) /
              6;
  EXPECT_NEAR(volume, 0.02 * 0.04 * 0.06, 1e-12);
  const auto seen = [&](double x) {
    const Vector3d eye(x, -1, 0.03), ray(0, 1, 0);
    const RayScene::Hit hit = box.scene().Cast(eye, ray);
    EXPECT_GE(hit.face, 0);
    RoomLight light;
    light.lamp = 0, light.ambient = 1;
    return box.Shade(hit, {ray, 1e-5, Vector3d::UnitZ()}, light)[1];
  };
  EXPECT_NEAR(seen(-0.007), 0, 1e-6);
  EXPECT_NEAR(seen(0.007), 1, 1e-6);
}

TEST(Furniture, LidOfADrumIsThePrintSeenFromAbove) {
  Furniture drum;
  Canvas canvas(0.2, 0.2, 1000, {0, 0, 0});
  canvas.Bar({0.15, 0.06}, {0.02, 0.02}, 0, {255, 255, 255});  // right of the middle, farther away
  const int lid = drum.AddPrint(std::move(canvas).Done());
  drum.AddDrum({}, 0.1, 0.02, -1, lid, Part::kSupport, true);
  drum.Finish();
  const Vector3d down(0, 0, -1);
  const RayScene::Hit hit = drum.scene().Cast({0.05, 0.04, 1}, down);
  ASSERT_GE(hit.face, 0);
  EXPECT_NEAR(hit.distance, 0.98, 1e-6);
  EXPECT_TRUE(drum.IsGround(hit.face));
  RoomLight light;
  light.lamp = 0, light.ambient = 1;
  EXPECT_NEAR(drum.Shade(hit, {down, 1e-4, Vector3d::UnitZ()}, light)[1], 1, 1e-3);
  const RayScene::Hit other = drum.scene().Cast({0.05, -0.04, 1}, down);
  EXPECT_NEAR(drum.Shade(other, {down, 1e-4, Vector3d::UnitZ()}, light)[1], 0, 1e-3);
}

}  // namespace keypose::synth::furniture_test
