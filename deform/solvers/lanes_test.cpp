#include "deform/solvers/lanes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#pragma GCC diagnostic ignored "-Wpsabi"

namespace keypose::lanes_test {

TEST(Lanes, ElementaryFunctionsAreThoseOfTheLibrary) {
  double worst_sine = 0, worst_exp = 0;
  for (int k = -40000; k < 40000; ++k) {
    const double x = 0.00173 * k;
    Lanes sine, cosine;
    plain::SinCos(plain::Spread(x), sine, cosine);
    worst_sine =
        std::max({worst_sine, std::abs(sine[1] - std::sin(x)), std::abs(cosine[2] - std::cos(x))});
    worst_exp = std::max(worst_exp, std::abs(plain::Exp(plain::Spread(x))[3] / std::exp(x) - 1));
  }
  EXPECT_LT(worst_sine, 4e-16);
  EXPECT_LT(worst_exp, 1e-15);
}

}  // namespace keypose::lanes_test
