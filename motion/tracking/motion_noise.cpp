#include "motion/tracking/motion_noise.h"

#include <algorithm>
#include <cmath>

#include "core/values/size_of.h"

namespace keypose::motion {
namespace {

constexpr int kMostRounds = 60;
constexpr double kSettledChange = 1e-3;  // relative change of both numbers in a round
constexpr double kLeastJerk = 1e-14;     // variance: what stands still has one too

using Numbers = std::vector<double>;
/// Of a symmetric band matrix: by frame, the entries with itself and with the next ones.
using Band = std::vector<std::array<double, kJerk + 1>>;

/// The course's posterior: means, and covariances of each frame with itself and the next ones.
struct Posterior {
  Numbers mean;
  Band covariance;
};

Band InformationOf(const Course& course, const MotionNoise& now, const Numbers& weights) {
  Band band(course.values.size() + kJerk);
  for (std::size_t f = 0; f < course.values.size(); ++f)
    band[f][0] = 1 / (now.noise * course.variances[f]);
  for (std::size_t f = 0; f < weights.size(); ++f)
    for (int i = 0; i <= kJerk; ++i)
      for (int j = i; j <= kJerk; ++j)
        band[f + i][j - i] += kJerkWeights[i] * kJerkWeights[j] * weights[f] / now.jerk;
  return band;
}

/// In place: L D L^T, with D in the diagonal. The last kJerk rows stay zero and bound the others.
void Factor(Band* band) {
  for (std::size_t f = 0; f + kJerk < band->size(); ++f) {
    auto& row = (*band)[f];
    for (int i = 1; i <= kJerk; ++i)
      for (int j = i; j <= kJerk; ++j) (*band)[f + i][j - i] -= row[i] * row[j] / row[0];
    for (int i = 1; i <= kJerk; ++i) row[i] /= row[0];
  }
}

/// Source of the covariances: Takahashi, Fagan & Chin, 1973: the inverse within the factor's band.
Posterior PosteriorOf(const Course& course, const MotionNoise& now, const Numbers& weights) {
  Band l = InformationOf(course, now, weights);
  Factor(&l);
  const int n = SizeOf(course.values);
  Posterior p{Numbers(l.size(), 0.0), Band(l.size())};
  for (int f = 0; f < n; ++f) {
    p.mean[f] += course.values[f] / (now.noise * course.variances[f]);
    for (int i = 1; i <= kJerk && f + i < n; ++i) p.mean[f + i] -= l[f][i] * p.mean[f];
  }
  for (int f = n - 1; f >= 0; --f) {
    p.mean[f] /= l[f][0];
    auto& own = p.covariance[f];
    for (int i = 1; i <= kJerk; ++i) p.mean[f] -= l[f][i] * p.mean[f + i];
    for (int i = 1; i <= kJerk; ++i)
      for (int j = 1; j <= kJerk; ++j)
        own[i] -= l[f][j] * p.covariance[f + std::min(i, j)][std::abs(i - j)];
    own[0] = 1 / l[f][0];
    for (int i = 1; i <= kJerk; ++i) own[0] -= l[f][i] * own[i];
  }
  p.mean.resize(course.values.size());
  return p;
}

/// Expected squares of the jerks.
Numbers SquaredJerks(const Posterior& p) {
  Numbers squares;
  for (std::size_t f = 0; f + kJerk < p.mean.size(); ++f) {
    double jerk = 0, variance = 0;
    for (int i = 0; i <= kJerk; ++i) {
      jerk += kJerkWeights[i] * p.mean[f + i];
      for (int j = 0; j <= kJerk; ++j)
        variance +=
            kJerkWeights[i] * kJerkWeights[j] * p.covariance[f + std::min(i, j)][std::abs(i - j)];
    }
    squares.push_back(jerk * jerk + std::max(0.0, variance));
  }
  return squares;
}

double NoiseOf(const Course& course, const Posterior& p) {
  double sum = 0;
  for (std::size_t f = 0; f < p.mean.size(); ++f) {
    const double off = course.values[f] - p.mean[f];
    sum += (off * off + p.covariance[f][0]) / course.variances[f];
  }
  return sum / static_cast<double>(p.mean.size());
}

/// Half of the course's own jerks, noise and all: where the search begins.
double FirstJerk(const Course& course) {
  double sum = 0;
  const std::size_t count = course.values.size() - kJerk;
  for (std::size_t f = 0; f < count; ++f) {
    double jerk = 0;
    for (int i = 0; i <= kJerk; ++i) jerk += kJerkWeights[i] * course.values[f + i];
    sum += jerk * jerk;
  }
  return std::max(kLeastJerk, sum / 2 / static_cast<double>(count));
}

}  // namespace

MotionNoise FindMotionNoise(const Course& course) {
  MotionNoise now;
  if (SizeOf(course.values) < kLeastFrames) return now;
  now.jerk = FirstJerk(course);
  Numbers weights(course.values.size() - kJerk, 1.0);
  for (int round = 0; round < kMostRounds; ++round) {
    const Posterior posterior = PosteriorOf(course, now, weights);
    const Numbers squares = SquaredJerks(posterior);
    double sum = 0;
    for (std::size_t f = 0; f < squares.size(); ++f) sum += weights[f] * squares[f];
    const MotionNoise before = now;
    now.jerk = std::max(kLeastJerk, sum / static_cast<double>(squares.size()));
    now.noise = std::max(1e-6, NoiseOf(course, posterior));
    for (std::size_t f = 0; f < squares.size(); ++f) weights[f] = JerkWeight(squares[f], now.jerk);
    if (std::abs(now.jerk / before.jerk - 1) < kSettledChange &&
        std::abs(now.noise / before.noise - 1) < kSettledChange)
      break;
  }
  return now;
}

}  // namespace keypose::motion
