#include "capture/room/first_masks.h"

#include <gtest/gtest.h>

#include <algorithm>
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

}  // namespace keypose::capture::first_masks_test
