#include "armature/matching/polyline.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include "armature/matching/testing/curves.h"
#include "core/values/errors.h"

namespace keypose::armature::polyline_test {

using Eigen::Vector3d;

TEST(Polyline, NearestPointOnPartStaysInThePart) {
  const Polyline curve = Hook();
  const Polyline::Foot foot = curve.Nearest(Vector3d(1, 0.5, 0), 0, curve.length());
  EXPECT_NEAR(foot.at, 0.5, 1e-14);
  EXPECT_NEAR(foot.squared_distance, 1, 1e-14);
  EXPECT_TRUE(foot.along.isApprox(Vector3d::UnitY()));
  const Polyline::Foot held = curve.Nearest(Vector3d(1, 0.5, 0), 1.25, curve.length());
  EXPECT_NEAR(held.at, 1.25, 1e-14);
  EXPECT_EQ(held.along, Vector3d(Vector3d::Zero()));
}

TEST(Polyline, TooFewOrBrokenPointsThrowInputError) {
  EXPECT_THROW(Polyline(PointsX3::Zero(1, 3)), InputError);
  PointsX3 broken = PointsX3::Zero(2, 3);
  broken(1, 2) = std::nan("");
  EXPECT_THROW(Polyline{broken}, InputError);
}

}  // namespace keypose::armature::polyline_test
