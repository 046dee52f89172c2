// Selects the pairs of photographs to match.
#pragma once

#include <utility>
#include <vector>

#include "core/values/progress.h"
#include "reconstruct/matching/colmap_database.h"

namespace keypose::reconstruct {

struct PairListOptions {
  int all_pairs_limit = 48;  ///< sets of at most this many images are matched in all pairs
  int neighbors = 4;  ///< number of images before and after, in the circular order of names, that
                      ///< are always paired
  int similar = 24;   ///< most similar images of each image that are also paired
  int preview_features = 512;  ///< largest features of each image that are used for similarity
};

using ImagePair = std::pair<int, int>;  ///< first < second

/// All pairs, sorted.
std::vector<ImagePair> AllPairs(int images);

/// Pairs of each image with its neighbours in a circle of `images`, sorted. Closes the ring if
/// there is only one ring.
std::vector<ImagePair> CircularPairs(int images, int neighbors);

/// Pairs of each image with the `similar` images with which it has the highest positive score;
/// either side suffices. Sorted.
/// @param scores  images x images, symmetric
std::vector<ImagePair> SimilarPairs(const Eigen::MatrixXi& scores, int similar);

/// The pairs to match: all if the set is small, else neighbours in order and the most similar
/// images. Similarity is the number of matches among the largest features of all pairs; it finds
/// each ring's closure and the neighbouring rings for any way of shooting.
/// Source: Wu, "Towards linear-time incremental structure from motion", 3DV 2013 (preemptive
/// matching).
/// Same result for any thread count.
std::vector<ImagePair> ChoosePairs(const std::vector<Features>& features,
                                   const PairListOptions& options, Progress* progress = nullptr);

}  // namespace keypose::reconstruct
