#include "armature/live/joint_timing.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose::armature::joint_timing_test {

using Eigen::MatrixXd;

MatrixXd Column(const std::vector<double>& values) {
  return Eigen::Map<const Eigen::VectorXd>(values.data(), SizeOf(values));
}

TEST(FilmValues, HoldRepeatsEachFrameToTheBit) {
  const MatrixXd film = FilmValues(Column({0.1, 0.7, 0.3}), 2, Between::kHold);
  EXPECT_EQ(film, Column({0.1, 0.1, 0.7, 0.7, 0.3, 0.3}));
}

TEST(FilmValues, LinearPassesAtEvenPace) {
  const MatrixXd film = FilmValues(Column({0, 3, 0}), 3, Between::kLinear);
  EXPECT_TRUE(film.isApprox(Column({0, 1, 2, 3, 2, 1, 0})));
}

TEST(FilmValues, SmoothPassesTheKeysAndNeverBeyondThem) {
  const std::vector<double> keys = {0, 0.1, 2, 2, 2, -1, 5, 5.01};
  const MatrixXd film = FilmValues(Column(keys), 10, Between::kSmooth);
  ASSERT_EQ(film.rows(), 71);
  for (int f = 0; f < 71; ++f) {
    const double a = keys[f / 10], b = keys[std::min(f / 10 + 1, 7)];
    EXPECT_GE(film(f), std::min(a, b) - 1e-12) << f;
    EXPECT_LE(film(f), std::max(a, b) + 1e-12) << f;
    if (f % 10 == 0) {
      EXPECT_EQ(film(f), a);
    }
    if (f >= 20 && f <= 40) {
      EXPECT_EQ(film(f), 2) << "a joint that stands still stays still";
    }
  }
  // No corner at a key that is passed: the pace before and behind it agree.
  const MatrixXd passing = FilmValues(Column({0, 1, 2.5}), 100, Between::kSmooth);
  EXPECT_NEAR(passing(101) - passing(100), passing(100) - passing(99), 1e-3);
}

/// The largest change of pace from one frame of the film to the next: at recorded frames that are
/// passed, and elsewhere.
std::pair<double, double> PaceJumps(const MatrixXd& film, int step) {
  double at_keys = 0, elsewhere = 0;
  for (Eigen::Index f = 1; f + 1 < film.rows(); ++f) {
    const double jump = std::abs(film(f + 1) - 2 * film(f) + film(f - 1));
    double& most = f % step == 0 ? at_keys : elsewhere;
    most = std::max(most, jump);
  }
  return {at_keys, elsewhere};
}

TEST(FilmValues, SmoothHasNoSeamWherePacesChange) {
  std::vector<double> swing;
  for (int f = 0; f < 24; ++f) swing.push_back(std::sin(0.5 * f) + 0.3 * std::sin(1.3 * f));
  const auto [smooth_at, smooth_elsewhere] =
      PaceJumps(FilmValues(Column(swing), 8, Between::kSmooth), 8);
  EXPECT_LT(smooth_at, smooth_elsewhere);
  const auto [even_at, even_elsewhere] =
      PaceJumps(FilmValues(Column(swing), 8, Between::kLinear), 8);
  EXPECT_GT(even_at, 1000 * even_elsewhere) << "as a test of the measure";
}

TEST(FilmValues, AnUnknownWayIsRefused) {
  EXPECT_EQ(BetweenNamed("smooth"), Between::kSmooth);
  EXPECT_THROW(BetweenNamed("jumps"), UsageError);
}

TEST(FilmValues, OneFrameIsOneFrame) {
  EXPECT_EQ(FilmValues(Column({4}), 5, Between::kSmooth).rows(), 1);
  EXPECT_EQ(FilmValues(Column({4}), 5, Between::kHold).rows(), 5);
}

TEST(Smoothed, NoiseShrinksAndStopsStay) {
  std::vector<double> noisy, clean;
  for (int f = 0; f < 60; ++f) {
    clean.push_back(f < 30 ? 0.1 * f : 3);
    noisy.push_back(clean.back() + (f < 30 ? 0.02 * (f % 2 ? 1 : -1) : 0));
  }
  const MatrixXd smooth = Smoothed(Column(noisy), 2);
  double before = 0, after = 0;
  for (int f = 4; f < 26; ++f) {
    before += std::abs(noisy[f] - clean[f]);
    after += std::abs(smooth(f) - clean[f]);
  }
  EXPECT_LT(after, 0.2 * before);
  for (int f = 31; f < 60; ++f) EXPECT_EQ(smooth(f), 3) << f;
  EXPECT_EQ(smooth(0), noisy[0]);
}

}  // namespace keypose::armature::joint_timing_test
