#include "reconstruct/matching/flat_pairs.h"

#include <iterator>
#include <opencv2/calib3d.hpp>

#include "core/numbers/parallel.h"

namespace keypose::reconstruct {
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

std::vector<char> FlatPairs(const std::vector<Features>& features, const FlatPairOptions& options,
                            double error_scale, const std::vector<Verified>& verified) {
  std::vector<char> flat(verified.size(), 0);
  ParallelFor(std::ssize(verified), [&](std::int64_t k) {
    const PairMatches& pair = verified[k].inliers;
    const int off = MatchesOffPlane(features[pair.first], features[pair.second], pair,
                                    error_scale * options.on_plane_px);
    flat[k] = off < options.fewest_off ||
              off < options.share_off * static_cast<double>(pair.features.size());
  });
  return flat;
}

}  // namespace keypose::reconstruct
