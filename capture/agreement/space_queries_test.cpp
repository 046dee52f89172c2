#include "capture/agreement/space_queries.h"

#include <gtest/gtest.h>

#include <cmath>

#include "capture/testing/test_ring.h"
#include "core/values/errors.h"

namespace keypose::capture::space_queries_test {

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

}  // namespace keypose::capture::space_queries_test
