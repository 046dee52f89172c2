#include "motion/body/body_surface.h"

#include <gtest/gtest.h>

#include "core/surfaces/geometry.h"
#include "motion/body/body_pose.h"

namespace keypose::motion::body_surface_test {

TEST(BodySurface, EverySegmentIsAClosedManifold) {
  const BodyShape shape = AverageShape();
  const LocalSurface surface = SurfaceOf(shape);
  for (int s = 0; s < kSegments; ++s) {
    const ClosedReport report = CheckClosed({surface.points[s], SegmentFaces(), {}, {}, {}, {}});
    EXPECT_TRUE(report.closed()) << Segments()[s].name;
    EXPECT_EQ(report.components, 1);
    EXPECT_EQ(report.euler, 2);
  }
  const PosedBody body = Posed({}, shape);
  const PointsX3 points = BodyPoints(surface, body);
  EXPECT_EQ(CheckClosed({points, BodyFaces(), {}, {}, {}, {}}).components, kSegments);
  // A person of 1.75 m, 1.7 m wide with its arms out, and 0.3 m deep at the feet.
  const Eigen::RowVector3d size = points.colwise().maxCoeff() - points.colwise().minCoeff();
  EXPECT_NEAR(size.z(), 1.75, 0.03);
  EXPECT_NEAR(size.x(), 1.78, 0.1);
  EXPECT_NEAR(shape.height(), 1.75, 0.03);
}

TEST(BodySurface, LeftAndRightAreMirrored) {
  const PointsX3 points = BodyPoints(SurfaceOf(AverageShape()), Posed({}, AverageShape()));
  for (const auto& [left, right] : {std::pair{4, 7}, {6, 9}, {10, 13}, {12, 15}}) {
    const auto rows = [&](int s) {
      return points.middleRows(s * kSegmentVertices, kSegmentVertices);
    };
    EXPECT_NEAR(rows(left).col(0).maxCoeff(), -rows(right).col(0).minCoeff(), 1e-12);
    EXPECT_NEAR(rows(left).col(2).mean(), rows(right).col(2).mean(), 1e-12);
  }
}

}  // namespace keypose::motion::body_surface_test
