#include "capture/agreement/view_consensus.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "capture/agreement/space_queries.h"
#include "capture/testing/test_ring.h"

namespace keypose::capture::view_consensus_test {

const SpaceOptions kCoarse{.resolution = 80};

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

}  // namespace keypose::capture::view_consensus_test
