#include "synth/rooms/canvas.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/pictures/srgb.h"
#include "synth/rooms/print.h"

namespace keypose::synth::canvas_test {

using Eigen::Vector2d;

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

}  // namespace keypose::synth::canvas_test
