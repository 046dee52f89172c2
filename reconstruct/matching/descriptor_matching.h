// Exhaustive matching of SIFT descriptors, in integers: the same matches on every processor and for
// any thread count.
#pragma once

#include <vector>

#include "reconstruct/matching/colmap_database.h"

namespace keypose::reconstruct {

struct MatchOptions {
  /// largest ratio of the angles to the nearest and to the second nearest descriptor
  double max_ratio = 0.8;
  double max_distance = 0.7;  ///< largest angle to the nearest [rad]
};

/// Largest and second largest dot product of a descriptor with others, and the index of the
/// largest.
struct NearestTwo {
  int dot = -1, second = -1, index = -1;  ///< -1: none
  void Offer(int value, int at) {
    if (value > dot) {
      second = dot;
      dot = value;
      index = at;
    } else if (value > second) {
      second = value;
    }
  }
};

/// Mutual nearest neighbours that pass both tests in both directions.
std::vector<std::pair<std::uint32_t, std::uint32_t>> MutualMatches(
    const std::vector<NearestTwo>& of_a, const std::vector<NearestTwo>& of_b,
    const MatchOptions& options);

/// Mutual nearest neighbours that pass both tests in both directions, by index in `a`.
/// Cost: |a| |b| dot products of 128 16-bit integers.
/// Source: Lowe, IJCV 2004, with COLMAP's angular distance (descriptors have length 512).
std::vector<std::pair<std::uint32_t, std::uint32_t>> MatchDescriptors(const Features& a,
                                                                      const Features& b,
                                                                      const MatchOptions& options);

/// The `count` features of largest scale, in their order; so few that all pairs of images can be
/// matched.
Features LargestFeatures(const Features& features, int count);

}  // namespace keypose::reconstruct
