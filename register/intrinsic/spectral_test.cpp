// Spectra of surfaces, and maps refined in them.
#include "register/intrinsic/spectral.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/surfaces/shapes.h"

namespace keypose::registration::spectral_test {

TEST(LaplaceSpectrum, OfASphereIsThatOfTheTextbook) {
  Mesh ball = MakeIcosphere(4);
  ball.points *= 17;
  const Spectrum spectrum = LaplaceSpectrum(ball.points, ball.faces, 25);
  int k = 0;
  for (int degree = 0; degree < 4; ++degree)
    for (int order = -degree; order <= degree; ++order, ++k)
      EXPECT_NEAR(spectrum.values[k], 4 * std::acos(-1.0) * degree * (degree + 1),
                  0.01 * 4 * std::acos(-1.0) * 12)
          << "function " << k;
  const Eigen::MatrixXd gram =
      spectrum.functions.transpose() * spectrum.areas.asDiagonal() * spectrum.functions;
  EXPECT_LT((gram - Eigen::MatrixXd::Identity(25, 25)).cwiseAbs().maxCoeff(), 1e-9);
}

}  // namespace keypose::registration::spectral_test
