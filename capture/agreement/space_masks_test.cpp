// Masks that agree in space, on a ring of photographs of a ball with an exact outline.
#include "capture/agreement/space_masks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "capture/agreement/space_queries.h"
#include "capture/testing/test_ring.h"
#include "core/numbers/parallel.h"
#include "core/values/errors.h"

namespace keypose::capture::space_masks_test {

const SpaceOptions kCoarse{.resolution = 80};

TEST(ContradictionsByOthers, CountsTheOthersAndNeverTheViewItself) {
  const TestRing ring = MakeTestRing();
  const std::vector<Image8> contradictions =
      ContradictionsByOthers(ring.views, ring.masks, kCoarse);
  EXPECT_EQ(*contradictions[0].at(kRingWidth / 2, kRingHeight / 2), 0);
  EXPECT_EQ(*contradictions[0].at(3, 3), 3);  // 18 views: a sixth
  // No other view contradicts the part that view 9 lacks; most views contradict a bright object
  // that two views show.
  EXPECT_EQ(*contradictions[9].at(kRingWidth / 2 - 20, kRingHeight / 2 + 20), 0);
  EXPECT_GE(*contradictions[3].at(kRingWidth / 2 + 62, kRingHeight / 2), 3);
}

TEST(ThicknessOfHull, IsTheBallsChord) {
  TestRing ring = MakeTestRing();
  const std::vector<Image8> thickness = ThicknessOfHull(ring.views, ring.truths, kCoarse);
  // The space is the ball plus a margin of one voxel; the hull of 18 views is a little larger than
  // the ball.
  EXPECT_NEAR(*thickness[0].at(kRingWidth / 2, kRingHeight / 2), 97, 6);
  // Of the ray through the image 30 pixels beside the middle.
  const double sine = 30 / std::hypot(30, kRingFocal) * kRingDistance / kBallRadius;
  EXPECT_NEAR(*thickness[0].at(kRingWidth / 2 + 30, kRingHeight / 2),
              97 * std::sqrt(1 - sine * sine), 10);
  EXPECT_EQ(*thickness[0].at(3, 3), 0);
}

// With voxels of one pixel and a hull carved at two contradictions, the ball is a pixel larger all
// round: 5 %; the hull of 18 views adds some more.
TEST(AgreementInSpace, IsNearOneWhereMasksAreRightAndLowWhereOneIsNot) {
  TestRing ring = MakeTestRing();
  const auto agreement =
      AgreementInSpace(ring.masks, ContradictionsByOthers(ring.views, ring.masks, kCoarse));
  EXPECT_GT(agreement[0], 0.88);
  EXPECT_LT(agreement[3], agreement[0] - 0.04);
  EXPECT_LT(agreement[9], agreement[0] - 0.04);
}

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

TEST(ContradictionsByOthers, BlackMasksAndMasksWithoutCommonSpaceThrow) {
  TestRing ring = MakeTestRing();
  for (std::size_t i = 0; i < ring.views.size(); ++i)
    for (int y = 0; y < kRingHeight; ++y)
      for (int x = 0; x < kRingWidth; ++x)
        *ring.masks[i].at(x, y) =
            x < 12 && y < 12 && i % 2 == 0 ? 255 : (x > kRingWidth - 12 && i % 2 ? 255 : 0);
  EXPECT_THROW(
      ContradictionsByOthers(ring.views, ring.masks, SpaceOptions{.most_contradictions = 2}),
      InputError);
  for (Image8& mask : ring.masks) mask = Image8(kRingWidth, kRingHeight, 1, 0);
  EXPECT_THROW(ContradictionsByOthers(ring.views, ring.masks, kCoarse), InputError);
}

TEST(CheckOutlines, ViewThatDeniesWhatAllOthersUpholdIsAnOutlierAndGivesTheirSpaceBack) {
  TestRing ring = MakeTestRing();
  const std::vector<Image8> before = ContradictionsByOthers(ring.views, ring.truths, kCoarse);
  Redraw(ring, 7, 14, -9, 30);
  const auto by = [&](const std::vector<char>& inlier) {
    return Contradictions{ContradictionsByOthers(ring.views, ring.truths, kCoarse, inlier), 3};
  };
  Contradictions contradictions = by({});
  EXPECT_NE(contradictions.pictures[0].data, before[0].data);  // it has carved
  const ViewConsensus consensus = CheckOutlines(ring.truths, contradictions, by, {});
  EXPECT_FALSE(consensus.undecided);
  for (std::size_t i = 0; i < ring.views.size(); ++i) EXPECT_EQ(consensus.inlier[i], i != 7) << i;
  EXPECT_GT(consensus.fits[7].missing[0], 0.2);
  EXPECT_LT(consensus.fits[0].missing[0], 0.01);
}

TEST(CheckOutlines, TwoThatContradictInTheSameWayAreBothFound) {
  TestRing ring = MakeTestRing();
  Redraw(ring, 7, 14, -9, 30);
  Redraw(ring, 8, 14, -9, 30);
  const auto by = [&](const std::vector<char>& inlier) {
    return Contradictions{ContradictionsByOthers(ring.views, ring.truths, kCoarse, inlier), 3};
  };
  Contradictions contradictions = by({});
  const ViewConsensus consensus = CheckOutlines(ring.truths, contradictions, by, {});
  for (std::size_t i = 0; i < ring.views.size(); ++i)
    EXPECT_EQ(consensus.inlier[i], i != 7 && i != 8) << i;
}

/// Six upright columns in a circle; only gaps in line with each other are see-through.
bool OnColumns(const View& view, int x, int y) {
  const Eigen::Vector3d eye =
      view.camera_from_world.rotation.conjugate() * -view.camera_from_world.translation;
  const Eigen::Vector3d in_camera((x + 0.5 - kRingWidth / 2.0) / kRingFocal,
                                  (y + 0.5 - kRingHeight / 2.0) / kRingFocal, 1);
  const Eigen::Vector3d ray = view.camera_from_world.rotation.conjugate() * in_camera;
  for (int column = 0; column < 6; ++column) {
    const double angle = (10 + 60 * column) * M_PI / 180;
    const Eigen::Vector2d to = 0.55 * Eigen::Vector2d(std::cos(angle), std::sin(angle)) -
                               eye.head<2>(),
                          along = ray.head<2>();
    const double t = to.dot(along) / along.squaredNorm();
    if ((to - t * along).norm() < 0.2 && std::abs(eye.z() + t * ray.z()) < 0.6) return true;
  }
  return false;
}

TEST(CheckOutlines, ToLookThroughBetweenColumnsIsNoFault) {
  TestRing ring = MakeTestRing();
  for (std::size_t i = 0; i < ring.views.size(); ++i)
    for (int y = 0; y < kRingHeight; ++y)
      for (int x = 0; x < kRingWidth; ++x)
        *ring.truths[i].at(x, y) = OnColumns(ring.views[i], x, y) ? 255 : 0;
  const auto by = [&](const std::vector<char>& inlier) {
    return Contradictions{ContradictionsByOthers(ring.views, ring.truths, kCoarse, inlier), 3};
  };
  Contradictions contradictions = by({});
  // Some views lack far more than the median view of the part that no other view contradicts: only
  // these see through.
  const std::vector<OutlineFit> fits = FitsOfOutlines(ring.truths, contradictions, {});
  const auto most = std::max_element(fits.begin(), fits.end(),
                                     [](auto& a, auto& b) { return a.missing[0] < b.missing[0]; });
  ASSERT_GT(most->missing[0], 1.2 * ConsensusOptions{}.missing);
  const ViewConsensus consensus = CheckOutlines(ring.truths, contradictions, by, {});
  EXPECT_FALSE(consensus.undecided);
  EXPECT_EQ(std::count(consensus.inlier.begin(), consensus.inlier.end(), 1),
            std::ssize(ring.views));
}

TEST(Touched, AreTheFewViewsThatHoldWhatTheOthersSeePast) {
  ViewConsensus consensus;
  consensus.inlier.assign(18, 1);
  consensus.fits.resize(18);
  consensus.fits[5].excess = 0.3;
  EXPECT_EQ(Touched(consensus, {}), std::vector<std::size_t>{5});
  for (std::size_t i = 0; i < 9; ++i)
    consensus.fits[i].excess = 0.3;  // a support that half of them show
  EXPECT_TRUE(Touched(consensus, {}).empty());
}

}  // namespace keypose::capture::space_masks_test
