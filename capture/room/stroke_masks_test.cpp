#include "capture/room/stroke_masks.h"

#include <gtest/gtest.h>

#include <cmath>

#include "capture/testing/test_ring.h"

namespace keypose::capture::stroke_masks_test {

/// Two things before a grey wall, and what a network sees of both.
struct TwoThings {
  Image8 picture{160, 120, 3, 128}, salience{160, 120, 1, 0}, left{160, 120, 1, 0};
  TwoThings() {
    for (int y = 0; y < 120; ++y)
      for (int x = 0; x < 160; ++x) {
        const bool on_left = std::hypot(x - 50, y - 60) < 25;
        const bool on_right = std::hypot(x - 110, y - 60) < 25;
        if (!on_left && !on_right) continue;
        picture.at(x, y)[on_left ? 0 : 2] = 220;
        picture.at(x, y)[1] = static_cast<std::uint8_t>(40 + (x * 7 + y * 5) % 20);
        *salience.at(x, y) = 255;
        *left.at(x, y) = on_left ? 255 : 0;
      }
  }
};

TEST(MaskOfStrokes, AClickTellsOneOfTwoThings) {
  const TwoThings two;
  const ViewStrokes click{{{50, 60}}, {}}, other{{}, {{110, 60}}};
  EXPECT_GT(Iou(MaskOfStrokes(two.picture, two.salience, click), two.left), 0.99);
  EXPECT_GT(Iou(MaskOfStrokes(two.picture, two.salience, other), two.left), 0.99);
}

TEST(MaskOfStrokes, WithoutANetworkColoursTell) {
  const TwoThings two;
  const ViewStrokes strokes{{{50, 60}}, {{110, 60}}};
  EXPECT_GT(Iou(MaskOfStrokes(two.picture, {}, strokes), two.left), 0.9);
  EXPECT_TRUE(MaskOfStrokes(two.picture, {}, {{}, {{110, 60}}}).empty());
}

// Where what the network saw is one part over both strokes, it errs; where they are two, it does
// not.
TEST(TakesBothForOne, OnlyWhereOnePartHoldsBothStrokes) {
  const TwoThings two;
  const ViewStrokes strokes{{{50, 60}}, {{110, 60}}};
  EXPECT_FALSE(TakesBothForOne(two.salience, strokes));
  const Image8 all(two.salience.width, two.salience.height, 1, 255);
  EXPECT_TRUE(TakesBothForOne(all, strokes));
  EXPECT_FALSE(TakesBothForOne(all, {{{50, 60}}, {}}));
  EXPECT_FALSE(TakesBothForOne({}, strokes));
}

}  // namespace keypose::capture::stroke_masks_test
