#include "synth/worlds/noise.h"

#include <gtest/gtest.h>

#include <Eigen/LU>

namespace keypose::synth::noise_test {

using Eigen::Vector3d;

TEST(GradientNoise, GradientMatchesDifferences) {
  Random random(3);
  for (int i = 0; i < 200; ++i) {
    const Vector3d x(random.Uniform(-9, 9), random.Uniform(-9, 9), random.Uniform(-9, 9));
    Vector3d gradient;
    GradientNoise(x, 5, &gradient);
    for (int k = 0; k < 3; ++k) {
      const Vector3d h = 1e-6 * Vector3d::Unit(k);
      EXPECT_NEAR((GradientNoise(x + h, 5) - GradientNoise(x - h, 5)) / 2e-6, gradient[k], 1e-6);
    }
  }
}

TEST(Random, IsUniformAndNormal) {
  Random random(1);
  double sum = 0, squares = 0, normal_squares = 0;
  constexpr int kCount = 20000;
  for (int i = 0; i < kCount; ++i) {
    const double u = random.Uniform(), n = random.Normal();
    sum += u, squares += u * u, normal_squares += n * n;
  }
  EXPECT_NEAR(sum / kCount, 0.5, 0.01);  // 5 sigma of the mean: 0.0102
  EXPECT_NEAR(squares / kCount, 1.0 / 3, 0.011);
  EXPECT_NEAR(normal_squares / kCount, 1, 0.05);  // 5 sigma: 0.05
}

}  // namespace keypose::synth::noise_test
