// Which raw matches of two photographs fit one rigid scene.
#pragma once

#include <optional>

#include "reconstruct/matching/colmap_database.h"

namespace keypose::reconstruct {

struct VerificationOptions {
  double max_error_px = 4;  ///< largest distance of an inlier from its epipolar line
  int min_inliers = 15;
  int max_iterations = 3000;  ///< samples of seven matches
};

/// Matches that passed the test, and their fundamental matrix.
struct Verified {
  PairMatches inliers;
  PairGeometry geometry;
};

/// Fits a fundamental matrix by RANSAC with a test for degenerate planes (a flat scene fits many
/// matrices) and local optimisation.
/// @return nothing with fewer inliers than required
/// Same result on any number of threads: each pair has its own random generator.
/// Source: Raguram et al., "USAC", TPAMI 2013, as in OpenCV.
std::optional<Verified> VerifyPair(const Features& first, const Features& second,
                                   const PairMatches& raw, const VerificationOptions& options);

}  // namespace keypose::reconstruct
