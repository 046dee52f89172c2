#include "interpolate/distortion_meter.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/surfaces/shapes.h"
#include "interpolate/testing/played_poses.h"

namespace keypose::interpolation::distortion_meter_test {

TEST(DistortionMeter, UniformGrowthHasKnownMeanDeviationAndRatio) {
  const Mesh mesh = MakeIcosphere(2);
  const DistortionReport report =
      Play({mesh.points, 2 * mesh.points}, mesh.faces, MakeSchedule({3})).distortion;
  const double a = std::pow(4, 0.25) - 1, b = 1, c = std::pow(4, 0.75) - 1, mean = (a + b + c) / 3;
  EXPECT_NEAR(report.segments[0].area.mean, mean, 1e-8);
  EXPECT_NEAR(
      report.segments[0].area.sd,
      std::sqrt(((a - mean) * (a - mean) + (b - mean) * (b - mean) + (c - mean) * (c - mean)) / 2),
      1e-8);
  EXPECT_LT(report.segments[0].area.path_deviation, 1e-8);
  EXPECT_NEAR(report.segments[0].linear_area.path_deviation, 1.5 * 1.5 / 2 - 1, 1e-9);
  EXPECT_NEAR(report.segments[0].volume.end_ratio, 8, 1e-12);
  EXPECT_NEAR(report.frames[2].linear_volume, 3.375, 1e-10);
  EXPECT_NEAR(report.frames[2].volume_path, std::sqrt(8.0), 1e-12);
  EXPECT_NEAR(report.frames[4].t, 1, 0);
  EXPECT_NEAR(report.frames[4].time_s, 4.0 / 24, 1e-12);
  int total = 0;
  for (int count : report.frames[1].faces.counts) total += count;
  EXPECT_EQ(total, mesh.face_count());
}

}  // namespace keypose::interpolation::distortion_meter_test
