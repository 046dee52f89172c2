#include <gtest/gtest.h>

#include <cmath>

#include "core/pictures/srgb.h"
#include "synth/photographs/enlarged.h"
#include "synth/rooms/canvas.h"
#include "synth/rooms/furniture.h"
#include "synth/rooms/print.h"

namespace keypose::synth::prints_test {

using Eigen::Vector2d;
using Eigen::Vector3d;

Image8 Steps() {  // four columns: black, white, black, white
  Image8 image(4, 2, 3);
  for (int y = 0; y < 2; ++y)
    for (int x = 0; x < 4; ++x)
      for (int c = 0; c < 3; ++c) image.at(x, y)[c] = x % 2 ? 255 : 0;
  return image;
}

TEST(Print, MiddleOfAPixelHasItsLightAndFarAwayAllAreMixed) {
  const Print print(Steps(), 0.4);
  EXPECT_NEAR(print.At(0.15, 0.05, 1e-4)[0], 1, 1e-6);
  EXPECT_NEAR(print.At(0.25, 0.05, 1e-4)[0], 0, 1e-6);
  EXPECT_NEAR(print.height_m(), 0.2, 1e-12);
  // Half of the light is sRGB 188, of which a byte is the nearest.
  EXPECT_NEAR(print.At(0.2, 0.1, 10)[1], 0.5, 0.003);
}

TEST(Print, BeyondItsBorderItEndsOrRepeats) {
  EXPECT_NEAR(Print(Steps(), 0.4).At(-0.35, 0.05, 1e-4)[0], 0, 1e-6);
  EXPECT_NEAR(Print(Steps(), 0.4, true).At(-0.25, 0.05, 1e-4)[0], 1, 1e-6);
  EXPECT_NEAR(Print(Steps(), 0.4, true).At(0.55, 0.05, 1e-4)[0], 1, 1e-6);
}

TEST(Canvas, ShapesAreWhereTheyAreDrawn) {
  Canvas canvas(0.1, 0.08, 2000, {0, 0, 0});
  canvas.Disc({0.03, 0.02}, 0.008, {255, 255, 255});
  const Print print = std::move(canvas).Done();
  double area = 0;
  Vector2d middle = Vector2d::Zero();
  for (double y = 0.00025; y < 0.08; y += 0.0005)
    for (double x = 0.00025; x < 0.1; x += 0.0005) {
      const double light = SrgbFromLinear(print.At(x, y, 1e-5)[2]);  // as bytes are mixed
      area += light * 0.0005 * 0.0005, middle += light * Vector2d(x, y);
    }
  middle *= 0.0005 * 0.0005 / area;
  EXPECT_NEAR(std::sqrt(area / 3.14159), 0.008, 0.0004);    // OpenCV's edge adds half a pixel
  EXPECT_LT((middle - Vector2d(0.03, 0.02)).norm(), 5e-5);  // a tenth of a pixel
}

TEST(Canvas, NoiseHasNoMeanAndIsSmooth) {
  double sum = 0, largest = 0, step = 0;
  constexpr int kCount = 40000;
  for (int i = 0; i < kCount; ++i) {
    const double x = 0.37 * (i % 200), y = 0.41 * (i / 200), value = PlaneNoise(x, y, 5);
    sum += value, largest = std::max(largest, std::abs(value));
    step = std::max(step, std::abs(PlaneNoise(x + 1e-4, y, 5) - value));
  }
  EXPECT_LT(std::abs(sum / kCount), 0.02);
  EXPECT_GT(largest, 0.6);
  EXPECT_LT(largest, 1.4);
  EXPECT_LT(step, 1e-3);
}

TEST(Canvas, PureHuesAreThePrimaries) {
  EXPECT_EQ(InkOf(0, 1, 1), (Ink{255, 0, 0}));
  EXPECT_EQ(InkOf(1.0 / 3, 1, 1), (Ink{0, 255, 0}));
  EXPECT_EQ(InkOf(2.0 / 3, 1, 1), (Ink{0, 0, 255}));
  EXPECT_EQ(InkOf(0.5, 1, 1), (Ink{0, 255, 255}));
  EXPECT_EQ(InkOf(0.2, 0, 0.6), (Ink{153, 153, 153}));
}

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

TEST(Enlarged, StraightLinesStayStraight) {
  ImageF ramp(8, 6, 2);
  for (int y = 0; y < 6; ++y)
    for (int x = 0; x < 8; ++x)
      ramp.at(x, y)[0] = static_cast<float>(2 * (x + 0.5) + (y + 0.5)), ramp.at(x, y)[1] = 3;
  const ImageF large = Enlarged(ramp, 3);
  ASSERT_EQ(large.width, 24);
  ASSERT_EQ(large.height, 18);
  for (int y = 6; y < 12; ++y)
    for (int x = 6; x < 18; ++x) {
      EXPECT_NEAR(large.at(x, y)[0], (2 * (x + 0.5) + (y + 0.5)) / 3, 1e-4);
      EXPECT_NEAR(large.at(x, y)[1], 3, 1e-5);
    }
  EXPECT_EQ(Enlarged(ramp, 1).data, ramp.data);
}

}  // namespace keypose::synth::prints_test
