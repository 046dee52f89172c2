// How much of a measured course is motion, and how much is noise, told from the course itself.
#pragma once

#include <array>
#include <vector>

#include "core/values/tuned.h"

namespace keypose::motion {

/// Tried on the generated performances with seeds 11 and 102, where 2 is hardly better.
struct MotionNoiseTuning {
  /// of Student's t, by which jerks are spread: few and large ones are motion too
  KEYPOSE_TUNED(double, kFreedom, 4);
};

/// One number, measured in each frame.
struct Course {
  std::vector<double> values;
  std::vector<double> variances;  ///< of the values, but for a common factor; > 0
};

/// A jerk is a third difference in time: by how much the acceleration differs from the frame
/// before.
inline constexpr int kJerk = 3;
inline constexpr std::array<double, kJerk + 1> kJerkWeights{-1, 3, -3, 1};

struct MotionNoise {
  double jerk = 0;   ///< variance of the jerks [1/frame^6]
  double noise = 1;  ///< the factor on the variances
};

/// The weight of a jerk among others: 1.25 for none, little for a hit or a stop.
inline double JerkWeight(double squared, double variance) {
  constexpr double nu = MotionNoiseTuning::kFreedom;
  return (nu + 1) / (nu + squared / variance);
}

/// Estimates both by expectation maximisation: noise is independent from frame to frame, and a
/// motion's acceleration changes by independent amounts, of which a few may be large.
///
/// @return jerk == 0: fewer than kLeastFrames frames, from which nothing can be told
/// Cost: linear in the frames.
/// Source: Shumway & Stoffer, "An approach to time series smoothing and forecasting using the EM
/// algorithm", 1982, for a random walk of acceleration; Lange, Little & Taylor, "Robust statistical
/// modeling using the t distribution", JASA 1989, for the weights.
MotionNoise FindMotionNoise(const Course& course);
inline constexpr int kLeastFrames = 8;

}  // namespace keypose::motion
