// Which raw matches of two photographs fit one rigid scene.
#pragma once

#include <optional>

#include "reconstruct/matching/colmap_database.h"

namespace keypose::reconstruct {

struct VerificationOptions {
  double max_error_px = 4;  ///< distance to the epipolar line that an inlier may have
  int min_inliers = 15;
  int max_iterations = 3000;  ///< samples of seven matches
};

/// Matches that stood the test, and the fundamental matrix that they agree on.
struct Verified {
  PairMatches inliers;
  PairGeometry geometry;
};

/// Fits a fundamental matrix by RANSAC with a guard against planes (a flat scene fits many) and
/// local optimisation.
/// @return nothing with fewer inliers than asked for
/// Same result on any number of threads: each pair draws from a generator of its own.
/// Source: Raguram et al., "USAC", TPAMI 2013, as OpenCV has it.
std::optional<Verified> VerifyPair(const Features& first, const Features& second,
                                   const PairMatches& raw, const VerificationOptions& options);

}  // namespace keypose::reconstruct
