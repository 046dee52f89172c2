#include "fit/following/calm.h"

#include <algorithm>
#include <cmath>

#include "core/numbers/parallel.h"
#include "core/values/size_of.h"

namespace keypose::fit {
namespace {

constexpr double kWindow = 3;        // standard deviations
constexpr double kLeastSure = 1e-3;  // what no view holds follows its neighbours, which counts too
constexpr double kMeanWeight = 0.1;  // of the mean over all frames

Eigen::ArrayXd WeightsOf(const Offsets& frame) { return frame.sure.array() + kLeastSure; }

Offsets CalmedFrame(const std::vector<Offsets>& frames, int f, double sigma, const PointsX3& mean) {
  const int reach = static_cast<int>(std::ceil(kWindow * sigma));
  PointsX3 sum = kMeanWeight * mean;
  Eigen::ArrayXd weights = Eigen::ArrayXd::Constant(mean.rows(), kMeanWeight), sure = 0 * weights;
  double all = 0;
  for (int g = std::max(0, f - reach); g <= std::min(SizeOf(frames) - 1, f + reach); ++g) {
    const double far = sigma > 0 ? (g - f) / sigma : 0.0, kernel = std::exp(-far * far / 2);
    const Eigen::ArrayXd w = kernel * WeightsOf(frames[g]);
    sum.array() += frames[g].local.array().colwise() * w;
    weights += w;
    sure += kernel * frames[g].sure.array();
    all += kernel;
  }
  return {sum.array().colwise() / weights, sure / all};
}

}  // namespace

PointsX3 MeanOffsets(const std::vector<Offsets>& frames) {
  PointsX3 sum = PointsX3::Zero(frames[0].local.rows(), 3);
  Eigen::ArrayXd weights = Eigen::ArrayXd::Zero(sum.rows());
  for (const Offsets& frame : frames) {
    const Eigen::ArrayXd w = WeightsOf(frame);
    sum.array() += frame.local.array().colwise() * w;
    weights += w;
  }
  return sum.array().colwise() / weights;
}

std::vector<Offsets> Calmed(const std::vector<Offsets>& frames, double sigma) {
  std::vector<Offsets> calmed(frames.size());
  if (frames.empty()) return calmed;
  const PointsX3 mean = MeanOffsets(frames);
  ParallelFor(SizeOf(frames), [&](std::int64_t f) {
    calmed[f] = CalmedFrame(frames, static_cast<int>(f), sigma, mean);
  });
  return calmed;
}

}  // namespace keypose::fit
