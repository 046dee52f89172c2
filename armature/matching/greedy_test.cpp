#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include "armature/matching/chain_match.h"
#include "armature/matching/testing/curves.h"

namespace keypose::armature::greedy_test {

using Eigen::VectorXd;

TEST(MatchGreedily, SameChainLiesOnItsCurve) {
  const Polyline curve = Hook();
  const ChainMatch match = MatchGreedily(curve, PiecesOf(curve));
  EXPECT_LT((match.joints - curve.points()).norm(), 1e-12);
  EXPECT_LT(match.far_gap, 1e-12);
}

TEST(MatchGreedily, NearAnchorIsExactJointsTouchTheCurveAndTheErrorEndsFar) {
  const Polyline curve = Hook();
  const VectorXd lengths = VectorXd::Constant(4, 1.06 * curve.length() / 4);
  const ChainMatch match = MatchGreedily(curve, lengths);
  EXPECT_EQ(match.near_gap, 0);
  for (int k = 1; k < 4; ++k)
    EXPECT_LT(curve.Nearest(match.joints.row(k), 0, curve.length()).squared_distance, 1e-24) << k;
  EXPECT_GT(match.far_gap, 0.05 * curve.length());
  // Beyond the curve's end the last direction is kept.
  EXPECT_NEAR(match.directions.row(3).dot(match.directions.row(2)), 1, 0.2);
}

}  // namespace keypose::armature::greedy_test
