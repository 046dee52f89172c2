#include "reconstruct/matching/verification.h"

#include <algorithm>
#include <opencv2/calib3d.hpp>

#include "core/values/size_of.h"
#include "core/values/tuned.h"

namespace keypose::reconstruct {

namespace {

// No record of the data. Sensitivity: docs/results/sensitivity.md.
struct VerificationTuning {
  KEYPOSE_TUNED(double, kConfidence, 0.9999);  // probability that the best matrix was tried
  KEYPOSE_TUNED(int, kLocalRounds, 10);        // of each local optimisation
  KEYPOSE_TUNED(int, kLocalSample, 40);        // matches of its samples
};

}  // namespace

std::optional<Verified> VerifyPair(const Features& first, const Features& second,
                                   const PairMatches& raw, const VerificationOptions& options) {
  const int count = SizeOf(raw.features);
  if (count < std::max(8, options.min_inliers)) return std::nullopt;
  cv::Mat a(count, 2, CV_64F), b(count, 2, CV_64F), inside;
  for (int k = 0; k < count; ++k) {
    const auto& [i, j] = raw.features[k];
    for (int c = 0; c < 2; ++c) {
      a.at<double>(k, c) = first.positions(i, c);
      b.at<double>(k, c) = second.positions(j, c);
    }
  }
  cv::UsacParams usac;
  usac.confidence = VerificationTuning::kConfidence;
  usac.maxIterations = options.max_iterations;
  usac.threshold = options.max_error_px;
  usac.isParallel = false;
  usac.randomGeneratorState = 0;
  usac.sampler = cv::SAMPLING_UNIFORM;
  usac.score = cv::SCORE_METHOD_MSAC;
  usac.loMethod = cv::LOCAL_OPTIM_INNER_LO;
  usac.loIterations = VerificationTuning::kLocalRounds;
  usac.loSampleSize = VerificationTuning::kLocalSample;
  cv::Mat matrix;
  try {
    matrix = cv::findFundamentalMat(a, b, inside, usac);
  } catch (const cv::Exception&) {
    return std::nullopt;  // points that span no plane
  }
  if (matrix.rows != 3 || matrix.cols != 3 || inside.total() != static_cast<std::size_t>(count))
    return std::nullopt;
  Verified verified{{raw.first, raw.second, {}},
                    {PairGeometry::kFundamental, Eigen::Matrix3d::Zero()}};
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) verified.geometry.matrix(r, c) = matrix.at<double>(r, c);
  if (!verified.geometry.matrix.allFinite()) return std::nullopt;
  for (int k = 0; k < count; ++k)
    if (inside.at<std::uint8_t>(k) != 0) verified.inliers.features.push_back(raw.features[k]);
  if (SizeOf(verified.inliers.features) < options.min_inliers) return std::nullopt;
  return verified;
}

}  // namespace keypose::reconstruct
