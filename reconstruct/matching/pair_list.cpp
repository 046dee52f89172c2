#include "reconstruct/matching/pair_list.h"

#include <algorithm>
#include <iterator>
#include <numeric>

#include "core/numbers/parallel.h"
#include "core/values/size_of.h"
#include "core/values/tuned.h"
#include "reconstruct/matching/descriptor_matching.h"

namespace keypose::reconstruct {
namespace {

// A lenient ratio: the number of matches only ranks, and selected pairs are tested strictly later.
// No record of the data. Sensitivity: docs/results/sensitivity.md.
struct PreviewTuning {
  // largest of the angles to the nearest and second descriptor
  KEYPOSE_TUNED(double, kRatio, 0.85);
  KEYPOSE_TUNED(double, kDistance, 0.8);  // rad: largest angle to the nearest
};

void SortUnique(std::vector<ImagePair>& pairs) {
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
}

/// Matches among the largest features of all pairs.
Eigen::MatrixXi PreviewScores(const std::vector<Features>& features, int preview_features,
                              Progress* progress) {
  const int images = SizeOf(features);
  std::vector<Features> previews(features.size());
  for (std::size_t i = 0; i < features.size(); ++i)
    previews[i] = LargestFeatures(features[i], preview_features);
  const std::vector<ImagePair> all = AllPairs(images);
  std::vector<int> counts(all.size());
  const MatchOptions lenient{.max_ratio = PreviewTuning::kRatio,
                             .max_distance = PreviewTuning::kDistance};
  ParallelFor(
      std::ssize(all),
      [&](std::int64_t k) {
        if (progress && progress->cancelled()) throw Cancelled();
        const auto [i, j] = all[k];
        counts[k] = static_cast<int>(MatchDescriptors(previews[i], previews[j], lenient).size());
      },
      16);
  Eigen::MatrixXi scores = Eigen::MatrixXi::Zero(images, images);
  for (std::size_t k = 0; k < all.size(); ++k)
    scores(all[k].first, all[k].second) = scores(all[k].second, all[k].first) = counts[k];
  return scores;
}

}  // namespace

std::vector<ImagePair> AllPairs(int images) {
  std::vector<ImagePair> pairs;
  for (int i = 0; i < images; ++i)
    for (int j = i + 1; j < images; ++j) pairs.emplace_back(i, j);
  return pairs;
}

std::vector<ImagePair> CircularPairs(int images, int neighbors) {
  std::vector<ImagePair> pairs;
  for (int i = 0; i < images; ++i)
    for (int step = 1; step <= neighbors; ++step)
      if (const int j = (i + step) % images; j != i)
        pairs.emplace_back(std::min(i, j), std::max(i, j));
  SortUnique(pairs);
  return pairs;
}

std::vector<ImagePair> SimilarPairs(const Eigen::MatrixXi& scores, int similar) {
  const int images = static_cast<int>(scores.rows());
  std::vector<ImagePair> pairs;
  for (int i = 0; i < images; ++i) {
    std::vector<int> order;
    for (int j = 0; j < images; ++j)
      if (j != i && scores(i, j) > 0) order.push_back(j);
    std::stable_sort(order.begin(), order.end(),
                     [&](int a, int b) { return scores(i, a) > scores(i, b); });
    order.resize(std::min(order.size(), static_cast<std::size_t>(std::max(0, similar))));
    for (const int j : order) pairs.emplace_back(std::min(i, j), std::max(i, j));
  }
  SortUnique(pairs);
  return pairs;
}

std::vector<ImagePair> ChoosePairs(const std::vector<Features>& features,
                                   const PairListOptions& options, Progress* progress) {
  const int images = SizeOf(features);
  if (images <= options.all_pairs_limit) return AllPairs(images);
  std::vector<ImagePair> pairs = CircularPairs(images, options.neighbors);
  const auto similar =
      SimilarPairs(PreviewScores(features, options.preview_features, progress), options.similar);
  pairs.insert(pairs.end(), similar.begin(), similar.end());
  SortUnique(pairs);
  return pairs;
}

}  // namespace keypose::reconstruct
