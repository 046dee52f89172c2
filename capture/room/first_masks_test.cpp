#include "capture/room/first_masks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "capture/testing/test_ring.h"
#include "core/numbers/parallel.h"

namespace keypose::capture::first_masks_test {

const Eigen::Vector3d kMiddle = Eigen::Vector3d::Zero();

/// A network that knows the truth, but for one view, in which it sees something in a corner.
Salience KnowsAllBut(const TestRing& ring, int wrong) {
  return [&ring, wrong](const Image8& rgb, bool) {
    for (std::size_t i = 0; i < ring.images.size(); ++i) {
      if (ring.images[i].data != rgb.data) continue;
      if (static_cast<int>(i) != wrong) return ring.truths[i];
      Image8 corner(rgb.width, rgb.height, 1, 0);
      for (int y = 0; y < 40; ++y)
        for (int x = 0; x < 50; ++x) *corner.at(x, y) = 255;
      return corner;
    }
    return Image8(rgb.width, rgb.height, 1, 0);
  };
}

struct First {
  ToldFigure told;
  std::vector<Image8> masks;
};

First Make(const TestRing& ring, const Salience& salience) {
  First first;
  first.told = AskAboutFigure(ring.images, ring.views, kMiddle,
                              std::vector<int>(ring.views.size(), 0), {}, salience, {});
  if (!first.told.fitting.empty())
    first.masks = CarryToAll(ring.images, ring.views, first.told, {}, {}, {});
  return first;
}

TEST(ViewsToAsk, AreFarApartAndOnlyOnce) {
  const TestRing ring = MakeTestRing();
  const std::vector<int> asked = ViewsToAsk(ring.views, kMiddle, 4, {7});
  ASSERT_EQ(asked.size(), 4u);
  EXPECT_EQ(asked[0], 7);
  for (std::size_t a = 0; a < asked.size(); ++a)
    for (std::size_t b = 0; b < a; ++b) {
      const Eigen::Vector3d x = ring.views[asked[a]].Center(), y = ring.views[asked[b]].Center();
      EXPECT_LT(x.normalized().dot(y.normalized()), std::cos(0.9));
    }
}

TEST(TurnsToUpright, FollowsTheWorldsZ) {
  View view = MakeTestRing().views[0];
  EXPECT_EQ(TurnsToUpright(view, kMiddle), 0);
  const Eigen::Quaterniond roll(Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitZ()));
  view.camera_from_world = Compose({roll, Eigen::Vector3d::Zero()}, view.camera_from_world);
  EXPECT_EQ(TurnsToUpright(view, kMiddle), 3);  // z points to the right in the picture
}

TEST(AskAboutFigure, FivePicturesTellAllOthers) {
  const TestRing ring = MakeTestRing();
  const First first = Make(ring, KnowsAllBut(ring, -1));
  ASSERT_EQ(first.masks.size(), ring.images.size());
  EXPECT_EQ(first.told.asked.size(), 5u);
  for (std::size_t i = 0; i < first.masks.size(); ++i) {
    if (i == 9) continue;  // a part of the ball is as dark as the wall there
    EXPECT_GT(Iou(first.masks[i], ring.truths[i]), 0.9) << "view " << i;
  }
}

// What the network sees in one picture does not fit what it sees in the others: it is not believed.
TEST(AskAboutFigure, AnOpinionThatDoesNotFitIsLeftOut) {
  const TestRing ring = MakeTestRing();
  const int wrong = Make(ring, KnowsAllBut(ring, -1)).told.asked[2];
  const First first = Make(ring, KnowsAllBut(ring, wrong));
  EXPECT_EQ(std::count(first.told.fitting.begin(), first.told.fitting.end(), wrong), 0);
  ASSERT_EQ(first.masks.size(), ring.images.size());
  EXPECT_GT(Iou(first.masks[static_cast<std::size_t>(wrong)],
                ring.truths[static_cast<std::size_t>(wrong)]),
            0.85);
}

TEST(AskAboutFigure, ANetworkThatSeesNothingLeavesItUnclear) {
  const TestRing ring = MakeTestRing();
  const First first =
      Make(ring, [](const Image8& rgb, bool) { return Image8(rgb.width, rgb.height, 1, 0); });
  EXPECT_TRUE(first.told.fitting.empty());
  EXPECT_TRUE(first.masks.empty());
}

TEST(AskAboutFigure, SameBitsForAnyThreadCount) {
  const TestRing ring = MakeTestRing();
  SetThreadCount(1);
  const First one = Make(ring, KnowsAllBut(ring, -1));
  SetThreadCount(4);
  const First four = Make(ring, KnowsAllBut(ring, -1));
  SetThreadCount(0);
  ASSERT_EQ(one.masks.size(), four.masks.size());
  for (std::size_t i = 0; i < one.masks.size(); ++i)
    EXPECT_EQ(one.masks[i].data, four.masks[i].data);
}

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

}  // namespace keypose::capture::first_masks_test
