#include "armature/matching/match_parts.h"

#include <gtest/gtest.h>

#include <cmath>

#include "armature/matching/testing/curves.h"
#include "core/values/errors.h"

namespace keypose::armature::match_parts_test {

using Eigen::Vector3d;
using Eigen::VectorXd;

TEST(RequireLengths, RefusesNoneAndWhatIsNotPositive) {
  EXPECT_NO_THROW(RequireLengths(VectorXd::Constant(2, 0.1)));
  EXPECT_THROW(RequireLengths(VectorXd()), InputError);
  for (const double bad : {0.0, -1.0, std::nan(""), HUGE_VAL})
    EXPECT_THROW(RequireLengths(VectorXd::Constant(1, bad)), InputError) << bad;
}

TEST(CurveDirections, OfTheCurvesOwnPiecesAreTheirs) {
  const Polyline curve = Hook();
  const Directions directions = CurveDirections(curve, PiecesOf(curve));
  const PointsX3& points = curve.points();
  for (Eigen::Index i = 0; i + 1 < points.rows(); ++i) {
    const Vector3d piece = points.row(i + 1) - points.row(i);
    EXPECT_LT((directions[i] - piece.normalized()).norm(), 1e-12) << i;
  }
}

TEST(Measured, ChainOnItsCurveHasNoGapsAndAMovedOneHasItsMove) {
  const Polyline curve = Hook();
  const VectorXd lengths = PiecesOf(curve);
  const Directions directions = CurveDirections(curve, lengths);
  const Vector3d start = curve.points().row(0);
  const ChainMatch on = Measured(curve, lengths, directions, start);
  EXPECT_LT((on.joints - curve.points()).norm(), 1e-12);
  EXPECT_LT(on.mean_distance, 1e-12);
  const ChainMatch off = Measured(curve, lengths, directions, start + Vector3d(0, 0, -0.5));
  EXPECT_NEAR(off.near_gap, 0.5, 1e-12);
  EXPECT_NEAR(off.far_gap, 0.5, 1e-12);
  EXPECT_GT(off.mean_distance, 0.3);
}

TEST(DirectionsOf, AreTheRows) {
  PointsX3 rows(2, 3);
  rows << 1, 0, 0, 0, 0, -1;
  const Directions directions = DirectionsOf(rows);
  ASSERT_EQ(directions.size(), 2u);
  EXPECT_EQ(directions[1], Vector3d(0, 0, -1));
}

}  // namespace keypose::armature::match_parts_test
