#include "motion/tracking/motion_noise.h"

#include <gtest/gtest.h>

#include <cmath>

#include "motion/tracking/testing/wandering.h"

namespace keypose::motion::motion_noise_test {

TEST(FindMotionNoise, TellsNoiseFromMotion) {
  constexpr double kChange = 0.02;
  for (const double deviation : {0.02, 0.05, 0.2}) {
    Noise noise(7);
    Course course;
    for (const double x : Wandering(400, kChange, 0, &noise)) {
      // The variances that are claimed are wrong by a factor of four.
      course.values.push_back(x + deviation * noise.Draw());
      course.variances.push_back(deviation * deviation / 4);
    }
    const MotionNoise found = FindMotionNoise(course);
    EXPECT_NEAR(std::sqrt(found.noise), 2, 0.3) << deviation;
    EXPECT_NEAR(std::sqrt(found.jerk), kChange, 0.4 * kChange) << deviation;
  }
}

TEST(FindMotionNoise, AFewHitsAreMotionAndNotNoise) {
  Noise noise(3);
  Course course;
  double at = 0, speed = 0.2;
  for (int f = 0; f < 200; ++f) {
    if (f % 40 == 20) speed = -speed;
    at += speed;
    course.values.push_back(at + 0.01 * noise.Draw()), course.variances.push_back(1e-4);
  }
  const MotionNoise found = FindMotionNoise(course);
  EXPECT_NEAR(std::sqrt(found.noise), 1, 0.2);
  EXPECT_LT(std::sqrt(found.jerk), 0.02);  // a hit changes the speed by 0.4
}

}  // namespace keypose::motion::motion_noise_test
