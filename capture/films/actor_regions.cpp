#include "capture/films/actor_regions.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "capture/pictures/cv_image.h"

namespace keypose::capture {
namespace {

constexpr double kNear = 0.02;      // of the longer side: pieces of the actor are so near to it
constexpr double kSmallest = 0.01;  // of the actor: smaller pieces are specks

cv::Mat Widened(const cv::Mat& mask) {
  const int radius =
      std::max(2, static_cast<int>(std::lround(kNear * std::max(mask.cols, mask.rows))));
  cv::Mat wide;
  cv::dilate(mask, wide,
             cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * radius + 1, 2 * radius + 1}));
  return wide;
}

/// Number of pixels of each component, of those in `where`.
std::vector<double> Areas(const cv::Mat& components, int count, const cv::Mat& where) {
  std::vector<double> areas(static_cast<std::size_t>(count), 0);
  for (std::size_t p = 0; p < components.total(); ++p)
    if (where.empty() || where.data[p]) areas[components.ptr<int>()[p]] += 1;
  areas[0] = 0;
  return areas;
}

}  // namespace

Image8 ZoneAround(const Image8& mask) { return ImageOf(Widened(MatOf(mask))); }

ActorRegions ChooseActor(const Image8& regions, const Image8& zone) {
  ActorRegions chosen;
  cv::Mat components;
  const int count = cv::connectedComponents(MatOf(regions), components, 8, CV_32S);
  const std::vector<double> areas = Areas(components, count, {});
  std::vector<double> expected = areas;
  if (!zone.empty()) expected = Areas(components, count, MatOf(zone));
  if (*std::max_element(expected.begin(), expected.end()) == 0) expected = areas;
  const auto main = std::max_element(expected.begin(), expected.end()) - expected.begin();
  cv::Mat mask = cv::Mat::zeros(components.size(), CV_8U);
  if (main == 0) return {ImageOf(mask), 0};
  mask.setTo(255, components == static_cast<int>(main));
  const std::vector<double> near = Areas(components, count, Widened(mask));
  int other = 0;
  for (int i = 1; i < count; ++i) {
    if (i == main || areas[i] < kSmallest * areas[main]) continue;
    if (near[i] > 0)
      mask.setTo(255, components == i);
    else if (other == 0 || areas[i] > areas[other])
      other = i;
  }
  chosen.mask = ImageOf(mask);
  chosen.other = areas[other] / areas[main];
  return chosen;
}

}  // namespace keypose::capture
