#include "reconstruct/turntable/upside_down.h"

#include <gtest/gtest.h>

#include "core/pictures/image_turns.h"
#include "reconstruct/matching/testing/ball_figure.h"

namespace keypose::reconstruct::upside_down_test {

TEST(UpsideDown, MatchesTellThePhotographsThatWereTurnedOver) {
  const Scene truth = Ring(15, 24);
  Matched matched = MatchesOf(truth);
  for (const std::size_t i : {3, 10}) {
    matched.features[i].positions.col(0) = kWidth - matched.features[i].positions.col(0).array();
    matched.features[i].positions.col(1) = kHeight - matched.features[i].positions.col(1).array();
  }
  const std::vector<int> found = UpsideDownByMatches(15, PointsOf(matched.pairs, matched.features));
  for (int i = 0; i < 15; ++i) EXPECT_EQ(found[i], i == 3 || i == 10) << i;
}

TEST(UpsideDown, OutlinesTellWhereNoMatchDoes) {
  std::vector<Image8> masks;
  for (int i = 0; i < 12; ++i) {  // pears: wider towards the bottom
    Image8 mask(kWidth, kHeight, 1, 0);
    for (int y = 40; y < 200; ++y)
      for (int x = 160 - (y - 40) / 3 - i % 3; x < 160 + (y - 40) / 3; ++x) *mask.at(x, y) = 255;
    masks.push_back(i == 4 ? TurnedOver(mask) : mask);
  }
  const std::vector<int> found = UpsideDownByOutlines(std::vector<int>(12, -1), masks);
  for (int i = 0; i < 12; ++i) EXPECT_EQ(found[i], i == 4) << i;
}

}  // namespace keypose::reconstruct::upside_down_test
