#include "report/evidence/one_way_distance.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "report/testing/minimal_report.h"

namespace keypose::report::one_way_distance_test {

TEST(DistanceTo, ShiftedCopyLiesItsShiftApart) {
  Mesh inner = Tetrahedron(), outer = Tetrahedron();
  outer.points.rowwise() += Eigen::RowVector3d(0, 0, 0.25);
  // Measured from the shifted copy: its top corner is 0.25 above the other's top corner; its base
  // is 0.25 above the other's base, but closer to the other's sides.
  const OneWayDistance way = DistanceTo(outer, inner, 20000);
  EXPECT_NEAR(way.max, 0.25, 1e-12);
  EXPECT_NEAR(way.at_vertex[3], 0.25, 1e-12);
  EXPECT_NEAR(way.at_vertex[0], 0, 1e-12);  // on the inner's edge
  EXPECT_LT(way.mean, way.rms);
  EXPECT_LE(way.p99, way.max);
  const OneWayDistance same = DistanceTo(inner, inner, 1000);
  EXPECT_NEAR(same.max, 0, 1e-9);
}

}  // namespace keypose::report::one_way_distance_test
