// A second matching along epipolar lines, for pairs with known geometry.
#pragma once

#include <Eigen/Core>
#include <utility>
#include <vector>

#include "reconstruct/matching/colmap_database.h"
#include "reconstruct/matching/descriptor_matching.h"

namespace keypose::reconstruct {

/// Mutual nearest neighbours among the features that the pair's geometry allows, with the ratio
/// test among those only. So a feature passes if similar features are far from its epipolar line,
/// which is the case on fur and grain.
///
/// @param geometry      of the two images; kOther gives no matches
/// @param max_error_px  largest Sampson distance (or transfer distance of a homography); the
/// feature of b must also be within sqrt(2) times that of its epipolar line
/// Cost: features near each line, found by a grid. Same matches on every processor.
std::vector<std::pair<std::uint32_t, std::uint32_t>> MatchGuided(const Features& a,
                                                                 const Features& b,
                                                                 const PairGeometry& geometry,
                                                                 const MatchOptions& options,
                                                                 double max_error_px);

}  // namespace keypose::reconstruct
