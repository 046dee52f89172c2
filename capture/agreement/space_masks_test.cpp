// Masks that agree in space, on a ring of photographs of a ball with an exact outline.
#include "capture/agreement/space_masks.h"

#include <gtest/gtest.h>

#include "capture/testing/test_ring.h"
#include "core/numbers/parallel.h"
#include "core/values/errors.h"

namespace keypose::capture::space_masks_test {

const SpaceOptions kCoarse{.resolution = 80};

TEST(RefineInSpace, WhatSomethingElseHidesIsUnknownAndNotEmpty) {
  // In a third of the views something stands before the ball's left half.
  TestRing ring = MakeTestRing();
  SpaceOptions options = kCoarse;
  options.segmented = true;
  options.hidden.resize(ring.views.size());
  std::vector<Image8> masks = ring.truths;
  for (std::size_t v = 0; v < masks.size(); v += 3) {
    options.hidden[v] = Image8(kRingWidth / 2, kRingHeight / 2, 1, 0);
    for (int y = 0; y < kRingHeight; ++y)
      for (int x = 0; x < kRingWidth / 2; ++x) {
        *masks[v].at(x, y) = 0;
        *options.hidden[v].at(x / 2, y / 2) = 255;
      }
  }
  const RefinedMasks refined = RefineInSpace(ring.images, masks, ring.views, {}, {}, options);
  for (std::size_t v = 0; v < masks.size(); ++v) {
    EXPECT_TRUE(refined.consensus.inlier[v]) << v;
    EXPECT_GT(Iou(refined.masks[v], masks[v]), 0.97) << v << ": nothing of them is cut off";
  }
  options.hidden.clear();
  EXPECT_THROW(RefineInSpace(ring.images, masks, ring.views, {}, {}, options), InputError)
      << "without that the views see past all of the ball";
}

TEST(RefineInSpace, DropsWhatTwoViewsAddAndRestoresWhatOneLacks) {
  const TestRing ring = MakeTestRing();
  ASSERT_LT(Iou(ring.masks[3], ring.truths[3]), 0.95);
  ASSERT_LT(Iou(ring.masks[9], ring.truths[9]), 0.90);
  const RefinedMasks refined = RefineInSpace(ring.images, ring.masks, ring.views, {}, {}, kCoarse);
  for (std::size_t i = 0; i < refined.masks.size(); ++i)
    EXPECT_GT(Iou(refined.masks[i], ring.truths[i]), 0.97) << "view " << i;
  EXPECT_GT(refined.agreement[3], refined.agreement_before[3]);
}

/// A dark side in front of a dark set: the photograph alone does not determine where the ball ends,
/// and its mask lacks so much that the view is an outlier. Its colours agree with the others, so it
/// is segmented again with their contradictions.
TEST(RefineInSpace, AViewThatContradictsByOutlineAloneIsAskedOnceMoreWithTheOthers) {
  TestRing ring = MakeTestRing();
  Darken(ring, 14, 0, 2.2);
  ASSERT_LT(Iou(ring.masks[14], ring.truths[14]), 0.6);
  const RefinedMasks refined = RefineInSpace(ring.images, ring.masks, ring.views, {}, {}, kCoarse);
  EXPECT_FALSE(refined.consensus_before.inlier[14]);
  EXPECT_TRUE(refined.consensus.inlier[14]);
  EXPECT_GT(Iou(refined.masks[14], ring.truths[14]), 0.95);
}

/// This photograph clearly shows the set around a smaller figure. It stays an outlier even with the
/// others' contradictions.
TEST(RefineInSpace, AViewThatClearlyShowsTheSetStaysAnOutlier) {
  TestRing ring = MakeTestRing();
  Redraw(ring, 14, 0, 0, 24);
  const RefinedMasks refined = RefineInSpace(ring.images, ring.masks, ring.views, {}, {}, kCoarse);
  EXPECT_FALSE(refined.consensus.inlier[14]);
  EXPECT_GT(Iou(refined.masks[14], ring.truths[14]), 0.9);
  for (std::size_t i = 0; i < refined.masks.size(); ++i)
    EXPECT_EQ(refined.consensus.inlier[i], i != 14) << "view " << i;
}

TEST(RefineInSpace, SameBitsForAnyThreadCount) {
  const TestRing ring = MakeTestRing();
  SetThreadCount(1);
  const RefinedMasks one = RefineInSpace(ring.images, ring.masks, ring.views, {}, {}, kCoarse);
  SetThreadCount(4);
  const RefinedMasks four = RefineInSpace(ring.images, ring.masks, ring.views, {}, {}, kCoarse);
  SetThreadCount(0);
  for (std::size_t i = 0; i < one.masks.size(); ++i)
    EXPECT_EQ(one.masks[i].data, four.masks[i].data);
  EXPECT_EQ(one.agreement, four.agreement);
}

}  // namespace keypose::capture::space_masks_test
