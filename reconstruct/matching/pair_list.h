// Which pairs of photographs to match.
#pragma once

#include <utility>
#include <vector>

#include "core/progress.h"
#include "reconstruct/matching/colmap_database.h"

namespace keypose::reconstruct {

struct PairListOptions {
  int all_pairs_limit = 48;  ///< up to this many images all pairs are matched
  int neighbors = 4;  ///< images before and after in the names' order are always paired; the order
                      ///< closes to a circle
  int similar = 24;   ///< most similar images of each image that are paired too
  int preview_features = 512;  ///< largest features of each image by which similarity is counted
};

using ImagePair = std::pair<int, int>;  ///< first < second

/// All pairs, sorted.
std::vector<ImagePair> AllPairs(int images);

/// Pairs of each image with its neighbours in a circle of `images`, sorted. Closes the ring when
/// one ring is all there is.
std::vector<ImagePair> CircularPairs(int images, int neighbors);

/// Pairs of each image with the `similar` images with which it has the highest positive score;
/// either side suffices. Sorted.
/// @param scores  images x images, symmetric
std::vector<ImagePair> SimilarPairs(const Eigen::MatrixXi& scores, int similar);

/// The pairs to match: all when that is affordable, else neighbours in order and the most similar
/// by matches among the largest features of all pairs, which is what finds each ring's closure and
/// the neighbouring rings without knowing how the photographs were taken.
/// Source: Wu, "Towards linear-time incremental structure from motion", 3DV 2013 (preemptive
/// matching). Same result for any thread count.
std::vector<ImagePair> ChoosePairs(const std::vector<Features>& features,
                                   const PairListOptions& options, Progress* progress = nullptr);

}  // namespace keypose::reconstruct
