#include "interpolate/timing/spline.h"

#include <gtest/gtest.h>

#include "interpolate/timing/frame_schedule.h"

namespace keypose::interpolation::spline_test {

TEST(SpanSpline, IsStraightInOneSpanAndMonotoneThroughMany) {
  const Schedule one = MakeSchedule({9});
  const SpanSpline<double> straight(one, {1.0, 3.0});
  EXPECT_NEAR(straight.At(0, 0.3), 1.6, 1e-15);
  const Schedule three = MakeSchedule({9, 4, 9});
  const SpanSpline<double> rising(three, {0.0, 1.0, 1.1, 5.0});
  double before = -1;
  for (int span = 0; span < 3; ++span)
    for (int k = 0; k <= 50; ++k) {
      const double value = rising.At(span, k / 50.0);
      EXPECT_GE(value, before - 1e-12);
      before = value;
    }
  EXPECT_EQ(rising.At(1, 0), 1.0);
  const SpanSpline<double> still(three, {2.0, 0.3, 0.3, 1.0});
  for (const double way : {0.1, 0.5, 0.77})
    EXPECT_EQ(still.At(1, way), 0.3);  // between equal keys, to the bit
}

TEST(SpanSpline, PassesItsWaypointsWithoutAJumpOfPace) {
  const Schedule schedule = MakeSchedule({9, 9});
  const SpanSpline<double> spline(schedule, {0.0, 1.0, 2.0}, {{{0.5, 3.0}}, {}});
  EXPECT_NEAR(spline.At(0, 0.5), 3, 1e-14);
  const double h = 1e-6;
  EXPECT_NEAR((spline.At(0, 0.5) - spline.At(0, 0.5 - h)) / h,
              (spline.At(0, 0.5 + h) - spline.At(0, 0.5)) / h, 1e-4);
  EXPECT_NEAR((spline.At(0, 1) - spline.At(0, 1 - h)) / h, (spline.At(1, h) - spline.At(1, 0)) / h,
              1e-4);
}

}  // namespace keypose::interpolation::spline_test
