#include "reconstruct/matching/flat_pairs.h"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <numeric>
#include <opencv2/calib3d.hpp>

#include "core/parallel.h"

namespace keypose::reconstruct {
namespace {

/// Size of the largest set of images that pairs with depth connect.
std::size_t LargestConnected(std::size_t images, const std::vector<Verified>& pairs,
                             const std::vector<char>& flat) {
  std::vector<std::size_t> parent(images), size(images, 0);
  std::iota(parent.begin(), parent.end(), std::size_t{0});
  const auto root = [&](std::size_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  for (std::size_t k = 0; k < pairs.size(); ++k)
    if (!flat[k]) parent[root(pairs[k].inliers.first)] = root(pairs[k].inliers.second);
  for (std::size_t i = 0; i < images; ++i) ++size[root(i)];
  return *std::max_element(size.begin(), size.end());
}

}  // namespace

int MatchesOffPlane(const Features& first, const Features& second, const PairMatches& pair,
                    double on_plane_px) {
  std::vector<cv::Point2f> a, b;
  for (const auto& [i, j] : pair.features) {
    a.emplace_back(first.positions(i, 0), first.positions(i, 1));
    b.emplace_back(second.positions(j, 0), second.positions(j, 1));
  }
  constexpr int kTries = 2000;
  constexpr double kConfidence = 0.999;
  cv::Mat inside;
  if (a.size() < 4 ||
      cv::findHomography(a, b, cv::RANSAC, on_plane_px, inside, kTries, kConfidence).empty())
    return static_cast<int>(a.size());
  return static_cast<int>(a.size()) - cv::countNonZero(inside);
}

int LeaveOutFlatPairs(const std::vector<Features>& features, const FlatPairOptions& options,
                      double error_scale, std::vector<Verified>& verified) {
  if (verified.empty()) return 0;
  std::vector<char> flat(verified.size(), 0);
  ParallelFor(std::ssize(verified), [&](std::int64_t k) {
    const PairMatches& pair = verified[k].inliers;
    const int off = MatchesOffPlane(features[pair.first], features[pair.second], pair,
                                    error_scale * options.on_plane_px);
    flat[k] = off < options.fewest_off ||
              off < options.share_off * static_cast<double>(pair.features.size());
  });
  if (static_cast<double>(LargestConnected(features.size(), verified, flat)) <
      options.connected * static_cast<double>(features.size()))
    return 0;
  std::size_t k = 0;
  return static_cast<int>(std::erase_if(verified, [&](const Verified&) { return flat[k++] != 0; }));
}

}  // namespace keypose::reconstruct
