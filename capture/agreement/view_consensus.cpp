#include "capture/agreement/view_consensus.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <opencv2/imgproc.hpp>

#include "core/numbers/parallel.h"
#include "core/numbers/statistics.h"

namespace keypose::capture {
namespace {

/// Area of a set of pixels after morphological opening with a disc.
double OpenedArea(const cv::Mat& set, double radius) {
  const int side = 2 * static_cast<int>(std::ceil(radius)) + 1;
  cv::Mat opened;
  cv::morphologyEx(set, opened, cv::MORPH_OPEN,
                   cv::getStructuringElement(cv::MORPH_ELLIPSE, {side, side}));
  return cv::countNonZero(opened);
}

OutlineFit FitOf(const Image8& mask, const Image8& contradictions, int most, double depth) {
  const double radius = depth * std::max(mask.width, mask.height);
  cv::Mat lacking[OutlineFit::kDoubts], beyond(mask.height, mask.width, CV_8UC1, cv::Scalar(0));
  for (cv::Mat& set : lacking) set = cv::Mat(mask.height, mask.width, CV_8UC1, cv::Scalar(0));
  double figure = 0;
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x) {
      const bool inside = *mask.at(x, y) > 127;
      const int contradicted = *contradictions.at(x, y);
      figure += contradicted == 0 || (inside && contradicted < most);
      for (int doubt = 0; doubt < OutlineFit::kDoubts; ++doubt)
        if (!inside && contradicted <= doubt) lacking[doubt].at<std::uint8_t>(y, x) = 255;
      if (inside && contradicted >= most) beyond.at<std::uint8_t>(y, x) = 255;
    }
  OutlineFit fit;
  figure = std::max(figure, 1.0);
  for (int doubt = 0; doubt < OutlineFit::kDoubts; ++doubt)
    fit.missing[doubt] = OpenedArea(lacking[doubt], radius) / figure;
  fit.excess = OpenedArea(beyond, radius) / figure;
  return fit;
}

/// Excess of a view's missing part over the median, the largest over the doubts.
std::vector<double> Faults(const std::vector<OutlineFit>& fits, const std::vector<char>& inlier) {
  std::vector<double> faults(fits.size(), 0);
  for (int doubt = 0; doubt < OutlineFit::kDoubts; ++doubt) {
    std::vector<double> of_inliers;
    for (std::size_t i = 0; i < fits.size(); ++i)
      if (inlier[i]) of_inliers.push_back(fits[i].missing[doubt]);
    const double usual = UpperMedian(std::move(of_inliers));
    for (std::size_t i = 0; i < fits.size(); ++i)
      faults[i] = std::max(faults[i], fits[i].missing[doubt] - usual);
  }
  return faults;
}

/// Share of a mask whose rays have no space left because of this view's contradictions alone.
double RobbedShare(const Image8& mask, const Image8& all, const Image8& without, double depth) {
  cv::Mat robbed(mask.height, mask.width, CV_8UC1, cv::Scalar(0));
  double figure = 1;
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x) {
      if (*mask.at(x, y) <= 127) continue;
      ++figure;
      if (*all.at(x, y) > *without.at(x, y)) robbed.at<std::uint8_t>(y, x) = 255;
    }
  return OpenedArea(robbed, depth * std::max(mask.width, mask.height)) / figure;
}

/// Whether at least two other inliers lose a part of their figure because of view i's
/// contradictions.
bool Robs(std::size_t i, const std::vector<Image8>& masks, const std::vector<char>& inlier,
          const Contradictions& all, const Contradictions& without,
          const ConsensusOptions& options) {
  std::vector<char> robbed(masks.size(), 0);
  ParallelFor(std::ssize(masks), [&](std::int64_t k) {
    const auto j = static_cast<std::size_t>(k);
    if (j == i || !inlier[j]) return;
    robbed[j] =
        RobbedShare(masks[j], all.pictures[j], without.pictures[j], options.depth) > options.robbed;
  });
  return std::count(robbed.begin(), robbed.end(), 1) >= 2;
}

}  // namespace

std::vector<OutlineFit> FitsOfOutlines(const std::vector<Image8>& masks,
                                       const Contradictions& contradictions,
                                       const ConsensusOptions& options) {
  std::vector<OutlineFit> fits(masks.size());
  ParallelFor(std::ssize(masks), [&](std::int64_t k) {
    const auto i = static_cast<std::size_t>(k);
    fits[i] = FitOf(masks[i], contradictions.pictures[i], contradictions.most, options.depth);
  });
  return fits;
}

std::vector<std::size_t> Touched(const ViewConsensus& consensus, const ConsensusOptions& options) {
  std::vector<double> excesses;
  for (const OutlineFit& fit : consensus.fits) excesses.push_back(fit.excess);
  const double usual = UpperMedian(excesses);
  std::vector<std::size_t> touched;
  for (std::size_t i = 0; i < consensus.fits.size(); ++i)
    if (consensus.inlier[i] && consensus.fits[i].excess > usual + options.touching)
      touched.push_back(i);
  if (static_cast<double>(touched.size()) >
      options.few * static_cast<double>(consensus.fits.size()))
    touched.clear();
  return touched;
}

ViewConsensus CheckOutlines(
    const std::vector<Image8>& masks, Contradictions& contradictions,
    const std::function<Contradictions(const std::vector<char>&)>& contradictions_by,
    const ConsensusOptions& options) {
  ViewConsensus consensus{std::vector<char>(masks.size(), 1),
                          FitsOfOutlines(masks, contradictions, options),
                          {},
                          false};
  const auto most =
      static_cast<std::size_t>(options.most_doubtful * static_cast<double>(masks.size()));
  std::vector<char> cleared(masks.size(), 0);  // views that see through gaps
  for (std::size_t gone = 0;;) {
    std::vector<double> faults = Faults(consensus.fits, consensus.inlier);
    for (std::size_t i = 0; i < faults.size(); ++i)
      if (!consensus.inlier[i] || cleared[i]) faults[i] = 0;
    const auto worst =
        static_cast<std::size_t>(std::max_element(faults.begin(), faults.end()) - faults.begin());
    if (faults[worst] <= options.missing) break;
    std::vector<char> inlier = consensus.inlier;
    inlier[worst] = 0;
    Contradictions without = contradictions_by(inlier);
    cleared[worst] = !Robs(worst, masks, inlier, contradictions, without, options);
    if (cleared[worst]) continue;
    consensus.undecided = gone++ >= most;
    if (consensus.undecided) break;
    consensus.inlier = std::move(inlier);
    contradictions = std::move(without);
    consensus.fits = FitsOfOutlines(masks, contradictions, options);
  }
  return consensus;
}

}  // namespace keypose::capture
