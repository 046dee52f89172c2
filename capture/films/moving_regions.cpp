#include "capture/films/moving_regions.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "capture/pictures/cv_image.h"

namespace keypose::capture {
namespace {

constexpr double kRarely = 0.03;          // share of frames in which a still pixel may differ
constexpr double kClosing = 0.016;        // of the longer side: gaps in what moves that are closed
constexpr double kSmallestRegion = 1e-3;  // of the picture

cv::Mat Disc(int radius) {
  return cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * radius + 1, 2 * radius + 1});
}

/// A colour that the usual one may have in a little more or less light.
bool MayBeLight(const PixelMode& mode, const PixelMode& usual) {
  constexpr double kMostChange = 1.35, kLargestHue = 4;
  const double light = (mode.lab[0] + 1.0) / (usual.lab[0] + 1.0);
  return light < kMostChange && light > 1 / kMostChange &&
         std::hypot(mode.lab[1] - 128 - light * (usual.lab[1] - 128),
                    mode.lab[2] - 128 - light * (usual.lab[2] - 128)) < kLargestHue;
}

/// Share of frames in which a pixel shows another thing than usual.
double OtherShare(const PixelMode* modes) {
  int same = modes[0].share;
  for (int m = 1; m < kMostModes; ++m)
    if (modes[m].share > 0 && MayBeLight(modes[m], modes[0])) same += modes[m].share;
  return std::max(0.0, 1 - same / 255.0);
}

/// Pixels that change, without specks, with gaps closed and holes filled.
cv::Mat MovingPixels(const PixelModes& modes) {
  cv::Mat moving(modes.height, modes.width, CV_8U);
  for (std::size_t p = 0; p < moving.total(); ++p)
    moving.data[p] = OtherShare(modes.of(p)) > kRarely ? 255 : 0;
  cv::medianBlur(moving, moving, 5);
  const int gap =
      std::max(2, static_cast<int>(std::lround(kClosing * std::max(modes.width, modes.height))));
  cv::morphologyEx(moving, moving, cv::MORPH_CLOSE, Disc(gap));
  std::vector<std::vector<cv::Point>> outlines;
  cv::findContours(moving, outlines, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_NONE);
  cv::drawContours(moving, outlines, -1, cv::Scalar(255), cv::FILLED);
  return moving;
}

double AmountIn(const PixelModes& modes, const cv::Mat& area) {
  double amount = 0;
  for (std::size_t p = 0; p < area.total(); ++p)
    if (area.data[p]) amount += OtherShare(modes.of(p));
  return amount;
}

}  // namespace

std::vector<MovingRegion> FindMovingRegions(const PixelModes& modes) {
  const cv::Mat moving = MovingPixels(modes);
  cv::Mat components, boxes, centres;
  const int count = cv::connectedComponentsWithStats(moving, components, boxes, centres, 8, CV_32S);
  std::vector<MovingRegion> regions;
  for (int i = 1; i < count; ++i) {
    const int* box = boxes.ptr<int>(i);
    if (box[cv::CC_STAT_AREA] < kSmallestRegion * static_cast<double>(moving.total())) continue;
    MovingRegion region;
    region.left = box[cv::CC_STAT_LEFT];
    region.top = box[cv::CC_STAT_TOP];
    region.right = region.left + box[cv::CC_STAT_WIDTH];
    region.bottom = region.top + box[cv::CC_STAT_HEIGHT];
    const cv::Mat area = components == i;
    region.amount = AmountIn(modes, area);
    region.area = ImageOf(area);
    regions.push_back(std::move(region));
  }
  std::stable_sort(
      regions.begin(), regions.end(),
      [](const MovingRegion& a, const MovingRegion& b) { return a.amount > b.amount; });
  return regions;
}

std::string PlaceOf(const MovingRegion& region, int width, int height) {
  const double x = 0.5 * (region.left + region.right) / width,
               y = 0.5 * (region.top + region.bottom) / height;
  const auto third = [](double at, const char* first, const char* last) -> std::string {
    if (at < 1 / 3.0) return first;
    return at > 2 / 3.0 ? last : "";
  };
  const std::string down = third(y, "top", "bottom"), across = third(x, "left", "right");
  if (down.empty() && across.empty()) return "in the middle";
  return "at the " + down + (down.empty() || across.empty() ? "" : " ") + across;
}

}  // namespace keypose::capture
