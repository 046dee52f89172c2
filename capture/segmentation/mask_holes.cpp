#include "capture/segmentation/mask_holes.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <numeric>
#include <opencv2/imgproc.hpp>

#include "capture/pictures/cv_image.h"
#include "capture/segmentation/trimap.h"
#include "core/numbers/parallel.h"
#include "core/numbers/statistics.h"
#include "core/values/tuned.h"

namespace keypose::capture {
namespace {

constexpr int kLeastArea = 16;         // pixels
constexpr double kLeastDepth = 1.4;    // pixels from a hole's middle to its side
constexpr double kLargestShare = 0.3;  // of the mask
constexpr int kAround = 5;             // pixels around a hole that are used

// Tuned on the holes, eyes and mouths of the synthetic rings of weak and rich texture, 36
// photographs of 1440 x 1080 (docs/algorithms/masks.md). Sensitivity:
// docs/results/sensitivity.md.
struct MaskHoleTuning {
  // least share of the empty set's lightness in the figure's shadow
  KEYPOSE_TUNED(double, kShade, 0.88);
  // 8 bit Lab; of single pixels' lightness, in addition to the background's usual difference; half
  // of it in colour
  KEYPOSE_TUNED(int, kNoise, 4);
  KEYPOSE_TUNED(int, kLooseNoise, 8);  // the same for a loose match to the empty set
  // 8 bit Lab distance of the figure beside a hole; a smooth shadow has less
  KEYPOSE_TUNED(double, kSetOff, 22);
  // largest share of the surroundings of a hole that may be closer: an eye's shadow has a pupil on
  // the other sides
  KEYPOSE_TUNED(double, kSmoothSide, 0.2);
  // least share of figure around a hole; strips along the outline have less
  KEYPOSE_TUNED(double, kEnclosed, 0.6);
  // per cent of the hull's longest side; rays through the figure itself are several times longer
  KEYPOSE_TUNED(int, kThinHole, 9);
};

using Lab = const std::uint8_t*;

bool Like(Lab pixel, Lab empty, const std::array<int, 3>& usual, int noise) {
  const int light = usual[0] + noise,
            darkest = static_cast<int>(MaskHoleTuning::kShade * empty[0]) - light;
  return pixel[0] <= empty[0] + light && pixel[0] >= darkest &&
         std::abs(pixel[1] - empty[1]) <= usual[1] + noise / 2 &&
         std::abs(pixel[2] - empty[2]) <= usual[2] + noise / 2;
}

cv::Rect Around(const cv::Rect& region, const cv::Size& size) {
  return cv::Rect(region.x - kAround, region.y - kAround, region.width + 2 * kAround,
                  region.height + 2 * kAround) &
         cv::Rect({0, 0}, size);
}

/// One region of pixels that look like the backdrop, within the mask.
class MaskHole {
 public:
  MaskHole(const cv::Mat& lab, const cv::Mat& mask, const cv::Mat& labels, int label,
           const cv::Rect& region)
      : around_(Around(region, mask.size())),
        lab_(lab(around_)),
        mask_(mask(around_)),
        pixels_(labels(around_) == label) {}

  bool Wide() const {
    cv::Mat padded, depth;
    cv::copyMakeBorder(pixels_, padded, 1, 1, 1, 1, cv::BORDER_CONSTANT, 0);
    cv::distanceTransform(padded, depth, cv::DIST_L2, 5);
    double deepest = 0;
    cv::minMaxLoc(depth, nullptr, &deepest);
    return deepest >= kLeastDepth;
  }

  /// Whether the figure a few pixels beside the region has other colours almost all round, and is
  /// on most sides.
  bool SetOff() const {
    cv::Mat near, far;
    cv::dilate(pixels_, near, cv::getStructuringElement(cv::MORPH_RECT, {3, 3}));
    cv::dilate(pixels_, far, cv::getStructuringElement(cv::MORPH_ELLIPSE, {7, 7}));
    const cv::Scalar mean = cv::mean(lab_, pixels_);
    std::vector<double> distances;
    double round = 0;
    for (int y = 0; y < far.rows; ++y)
      for (int x = 0; x < far.cols; ++x) {
        if (!far.at<std::uint8_t>(y, x) || near.at<std::uint8_t>(y, x)) continue;
        round += 1;
        const cv::Vec3b& c = lab_.at<cv::Vec3b>(y, x);
        if (mask_.at<std::uint8_t>(y, x))
          distances.push_back(
              Eigen::Vector3d(c[0] - mean[0], c[1] - mean[1], c[2] - mean[2]).norm());
      }
    if (distances.empty() ||
        static_cast<double>(distances.size()) < MaskHoleTuning::kEnclosed * round)
      return false;
    return QuantileAbove(std::move(distances), MaskHoleTuning::kSmoothSide) >=
           MaskHoleTuning::kSetOff;
  }

  /// @param corner  in the image, of the mask's part that this was made from
  /// @param scale   of the thickness's pixels over the image's
  bool Thin(const Image8& thickness, const cv::Point& corner, double scale) const {
    if (thickness.empty()) return true;
    std::vector<int> values;
    for (int y = 0; y < pixels_.rows; ++y)
      for (int x = 0; x < pixels_.cols; ++x) {
        if (!pixels_.at<std::uint8_t>(y, x)) continue;
        const cv::Point at = corner + around_.tl() + cv::Point(x, y);
        values.push_back(
            *thickness.at(std::min(static_cast<int>((at.x + 0.5) * scale), thickness.width - 1),
                          std::min(static_cast<int>((at.y + 0.5) * scale), thickness.height - 1)));
      }
    return UpperMedian(std::move(values)) <= MaskHoleTuning::kThinHole;
  }

  /// Removes the region and its border, which mixes hole and figure; boundary matting then locates
  /// the final border.
  void Open(const cv::Point& corner, cv::Mat mask) const {
    cv::Mat open;
    cv::dilate(pixels_, open, cv::getStructuringElement(cv::MORPH_CROSS, {3, 3}));
    mask(around_ + corner).setTo(0, open);
  }

  Region Pixels(const cv::Point& corner, int width) const {
    Region region;
    for (int y = 0; y < pixels_.rows; ++y)
      for (int x = 0; x < pixels_.cols; ++x)
        if (pixels_.at<std::uint8_t>(y, x))
          region.push_back((corner.y + around_.y + y) * width + corner.x + around_.x + x);
    return region;
  }

 private:
  cv::Rect around_;
  cv::Mat lab_, mask_, pixels_;
};

cv::Mat Candidates(const cv::Mat& lab, const cv::Mat& empty, const cv::Mat& mask,
                   const std::array<int, 3>& usual, int noise) {
  cv::Mat candidates(mask.size(), CV_8U, cv::Scalar(0));
  for (int y = 0; y < mask.rows; ++y)
    for (int x = 0; x < mask.cols; ++x)
      if (mask.at<std::uint8_t>(y, x) &&
          Like(&lab.at<cv::Vec3b>(y, x)[0], &empty.at<cv::Vec3b>(y, x)[0], usual, noise))
        candidates.at<std::uint8_t>(y, x) = 255;
  return candidates;
}

/// @param visit  called for each region in the mask that looks like the empty set, with the corner
/// of the mask's part that it was made from, and the backdrop's pixels over the image's
template <typename Visit>
void ForEachMaskHole(const Image8& image, const Backdrop& backdrop, const cv::Mat& mask, int noise,
                     const Visit& visit) {
  cv::Rect box = cv::boundingRect(mask);
  if (backdrop.empty.empty() || box.empty()) return;
  box = Around(box, mask.size());  // includes pixels beyond the outline
  cv::Mat lab, empty, labels, stats, middles;
  cv::cvtColor(MatOf(image)(box), lab, cv::COLOR_RGB2Lab);
  cv::resize(MatOf(backdrop.empty), empty, mask.size(), 0, 0, cv::INTER_LINEAR);
  const cv::Mat before = mask(box).clone();
  const int count =
      cv::connectedComponentsWithStats(Candidates(lab, empty(box), before, backdrop.usual, noise),
                                       labels, stats, middles, 4, CV_32S);
  const double largest = kLargestShare * cv::countNonZero(before),
               scale = static_cast<double>(backdrop.empty.width) / image.width;
  for (int k = 1; k < count; ++k) {
    const int* of = stats.ptr<int>(k);
    if (of[cv::CC_STAT_AREA] < kLeastArea || of[cv::CC_STAT_AREA] > largest) continue;
    visit(MaskHole(lab, before, labels, k,
                   {of[cv::CC_STAT_LEFT], of[cv::CC_STAT_TOP], of[cv::CC_STAT_WIDTH],
                    of[cv::CC_STAT_HEIGHT]}),
          box.tl(), scale);
  }
}

}  // namespace

Backdrops BackdropsOf(const std::vector<Image8>& lab, const std::vector<Image8>& trimaps,
                      const std::vector<Take>& takes, double largest_misfit) {
  Backdrops all{std::vector<Backdrop>(lab.size()), 0};
  std::vector<Backdrop>& backdrops = all.of;
  std::vector<double> figure(lab.size(), 0), like(figure);
  ParallelFor(std::ssize(lab), [&](std::int64_t k) {
    const auto i = static_cast<std::size_t>(k);
    Image8 empty = EmptySet(lab, trimaps, TakeOf(takes, i), i);
    if (Misfit(lab[i], empty, trimaps[i]) >= largest_misfit) return;
    backdrops[i].usual = UsualDifference(lab[i], empty, trimaps[i]);
    for (std::size_t p = 0; p < trimaps[i].data.size(); ++p)
      if (trimaps[i].data[p] == kObject) {
        figure[i] += 1;
        like[i] += Like(&lab[i].data[3 * p], &empty.data[3 * p], backdrops[i].usual, 0);
      }
    backdrops[i].empty = std::move(empty);
  });
  const auto sum = [](const std::vector<double>& values) {
    return std::accumulate(values.begin(), values.end(), 0.0);
  };
  all.alike = sum(like) / std::max(1.0, sum(figure));
  return all;
}

std::vector<Region> FindMaskHoles(const Image8& image, const Backdrop& backdrop, const Image8& mask,
                                  bool loosely) {
  std::vector<Region> regions;
  ForEachMaskHole(image, backdrop, MatOf(mask),
                  loosely ? MaskHoleTuning::kLooseNoise : MaskHoleTuning::kNoise,
                  [&](const MaskHole& hole, const cv::Point& corner, double) {
                    if (hole.Wide() && hole.SetOff())
                      regions.push_back(hole.Pixels(corner, mask.width));
                  });
  return regions;
}

void OpenMaskHoles(const Image8& image, const Backdrop& backdrop, Image8& mask) {
  cv::Mat whole = MatOf(mask).clone();
  ForEachMaskHole(
      image, backdrop, MatOf(mask), MaskHoleTuning::kNoise,
      [&](const MaskHole& hole, const cv::Point& corner, double scale) {
        if (hole.Wide() && hole.Thin(backdrop.thickness, corner, scale) && hole.SetOff())
          hole.Open(corner, whole);
      });
  mask = ImageOf(whole);
}

}  // namespace keypose::capture
