#include "capture/pictures/overlap.h"

#include <iterator>

#include <opencv2/calib3d.hpp>
#include <opencv2/features2d.hpp>

#include "capture/pictures/cv_image.h"
#include "core/numbers/parallel.h"
#include "core/values/errors.h"
#include "core/values/tuned.h"

namespace keypose::capture {
namespace {

constexpr int kMostFeatures = 400;

// No record of the data. Sensitivity: docs/results/sensitivity.md.
struct SharedPlacesTuning {
  KEYPOSE_TUNED(int, kFewestShared, 16);   // places; fewer are chance
  KEYPOSE_TUNED(double, kContrast, 0.02);  // SIFT's threshold
  KEYPOSE_TUNED(float, kRatio, 0.8F);      // largest of the distances to the nearest and second
  KEYPOSE_TUNED(double, kError_px, 2);     // largest distance from the epipolar line
};

struct Sighted {
  std::vector<cv::KeyPoint> places;
  cv::Mat descriptors;
};

Sighted FeaturesOf(const Preview& preview) {
  Sighted seen;
  const auto sift = cv::SIFT::create(kMostFeatures, 3, SharedPlacesTuning::kContrast);
  sift->detectAndCompute(MatOf(preview.grey), MatOf(preview.mask), seen.places, seen.descriptors);
  return seen;
}

std::vector<cv::DMatch> RatioMatches(const cv::Mat& from, const cv::Mat& to) {
  std::vector<std::vector<cv::DMatch>> nearest;
  cv::BFMatcher(cv::NORM_L2).knnMatch(from, to, nearest, 2);
  std::vector<cv::DMatch> kept;
  for (const auto& two : nearest)
    if (two.size() == 2 && two[0].distance < SharedPlacesTuning::kRatio * two[1].distance)
      kept.push_back(two[0]);
  return kept;
}

int SharedBy(const Sighted& first, const Sighted& second, double least_move_px) {
  const std::size_t fewest = SharedPlacesTuning::kFewestShared;
  if (first.places.size() < fewest || second.places.size() < fewest) return 0;
  const std::vector<cv::DMatch> there = RatioMatches(first.descriptors, second.descriptors),
                                back = RatioMatches(second.descriptors, first.descriptors);
  std::vector<int> match_back(second.places.size(), -1);
  for (const cv::DMatch& match : back) match_back[match.queryIdx] = match.trainIdx;
  std::vector<cv::Point2f> x, y;
  for (const cv::DMatch& match : there) {
    if (match_back[match.trainIdx] != match.queryIdx) continue;
    const cv::Point2f here = first.places[match.queryIdx].pt,
                      there_too = second.places[match.trainIdx].pt;
    if (cv::norm(here - there_too) < least_move_px) continue;
    x.push_back(here);
    y.push_back(there_too);
  }
  if (x.size() < fewest) return 0;
  cv::UsacParams usac;  // with its own random state: the same result in any order of the pairs
  usac.randomGeneratorState = 0;
  usac.isParallel = false;
  usac.threshold = SharedPlacesTuning::kError_px;
  usac.confidence = 0.99;
  usac.maxIterations = 1000;
  usac.sampler = cv::SAMPLING_UNIFORM;
  usac.score = cv::SCORE_METHOD_MSAC;
  usac.loMethod = cv::LOCAL_OPTIM_INNER_LO;
  usac.loIterations = 5;
  usac.loSampleSize = 20;
  cv::Mat fits;
  try {
    return cv::findFundamentalMat(x, y, fits, usac).empty() ? 0 : cv::countNonZero(fits);
  } catch (const cv::Exception&) {
    return 0;  // points that span no plane
  }
}

}  // namespace

std::vector<ImageTie> SharedPlaces(const std::vector<Preview>& previews,
                                   std::vector<ImageTie> pairs, double least_move_px,
                                   Progress* progress) {
  std::vector<Sighted> seen(previews.size());
  ParallelFor(std::ssize(previews), [&](std::int64_t i) {
    if (progress && progress->cancelled()) throw Cancelled();
    if (!previews[i].grey.empty()) seen[i] = FeaturesOf(previews[i]);
  });
  ParallelFor(
      std::ssize(pairs),
      [&](std::int64_t k) {
        ImageTie& tie = pairs[k];
        tie.matches = SharedBy(seen[tie.first], seen[tie.second], least_move_px);
      },
      8);
  std::erase_if(
      pairs, [](const ImageTie& tie) { return tie.matches < SharedPlacesTuning::kFewestShared; });
  return pairs;
}

std::vector<ImageTie> SharedPlaces(const std::vector<Preview>& previews, Progress* progress) {
  std::vector<ImageTie> pairs;
  for (int i = 0; i < std::ssize(previews); ++i)
    for (int j = i + 1; j < std::ssize(previews); ++j) pairs.push_back({i, j, 0});
  return SharedPlaces(previews, std::move(pairs), 0, progress);
}

}  // namespace keypose::capture
