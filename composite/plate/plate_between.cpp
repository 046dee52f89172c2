#include "composite/plate/plate_between.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

#include "composite/layer/linear_light.h"
#include "core/numbers/parallel.h"
#include "core/values/errors.h"

namespace keypose::composite {
namespace {

constexpr int kLevels = 6, kWindow = 25, kRounds = 4, kPolynomial = 7;
constexpr double kPolynomialSigma = 1.5;
constexpr int kDoubtfulLevels = 24;  // more than grain
constexpr int kWays = 3;             // rounds of looking up a flow where its pixel comes from

cv::Mat GreyOf(const ImageF& picture) {
  Image8 whole = Rounded(picture);
  const cv::Mat rgb(picture.height, picture.width, CV_8UC3, whole.data.data());
  cv::Mat grey;
  cv::cvtColor(rgb, grey, cv::COLOR_RGB2GRAY);
  return grey;
}

cv::Mat FlowOf(const cv::Mat& from, const cv::Mat& to) {
  cv::Mat flow;
  cv::calcOpticalFlowFarneback(from, to, flow, 0.5, kLevels, kWindow, kRounds, kPolynomial,
                               kPolynomialSigma, cv::OPTFLOW_FARNEBACK_GAUSSIAN);
  return flow;
}

/// Bilinear; the border is repeated. `read(x, y, c)` is a value at a pixel.
template <int kChannels, class Read>
std::array<float, kChannels> Sampled(int width, int height, double x, double y, const Read& read) {
  const double px = std::clamp(x, 0.0, width - 1.0), py = std::clamp(y, 0.0, height - 1.0);
  const int x0 = static_cast<int>(px), y0 = static_cast<int>(py);
  const int x1 = std::min(x0 + 1, width - 1), y1 = std::min(y0 + 1, height - 1);
  const double fx = px - x0, fy = py - y0;
  std::array<float, kChannels> value;
  for (int c = 0; c < kChannels; ++c)
    value[c] = static_cast<float>((1 - fy) * ((1 - fx) * read(x0, y0, c) + fx * read(x1, y0, c)) +
                                  fy * ((1 - fx) * read(x0, y1, c) + fx * read(x1, y1, c)));
  return value;
}

/// What a picture shows at a place that its pixels have moved to by a share of their flow.
std::array<float, 3> Moved(const ImageF& picture, const cv::Mat& flow, double share, int x, int y) {
  double from_x = x, from_y = y;
  for (int round = 0; round < kWays; ++round) {
    const auto way =
        Sampled<2>(picture.width, picture.height, from_x, from_y,
                   [&](int px, int py, int c) { return double{flow.at<cv::Vec2f>(py, px)[c]}; });
    from_x = x - share * way[0];
    from_y = y - share * way[1];
  }
  return Sampled<3>(picture.width, picture.height, from_x, from_y,
                    [&](int px, int py, int c) { return double(picture.at(px, py)[c]); });
}

}  // namespace

PlateBetweenTwo PlateBetween(const ImageF& before, const ImageF& after, double share) {
  if (before.width != after.width || before.height != after.height)
    throw InputError("composite: two plates of a moving camera differ in size");
  const cv::Mat a = GreyOf(before), b = GreyOf(after);
  const cv::Mat there = FlowOf(a, b), back = FlowOf(b, a);
  ImageF mixed(before.width, before.height, 3);
  std::atomic<std::int64_t> doubtful = 0;
  ParallelFor(before.height, [&](std::int64_t row) {
    const int y = static_cast<int>(row);
    std::int64_t differ = 0;
    for (int x = 0; x < before.width; ++x) {
      const auto one = Moved(before, there, share, x, y), two = Moved(after, back, 1 - share, x, y);
      float most = 0;
      for (int c = 0; c < 3; ++c) {
        most = std::max(most, std::abs(one[c] - two[c]));
        mixed.at(x, y)[c] = static_cast<float>((1 - share) * one[c] + share * two[c]);
      }
      differ += most > kDoubtfulLevels;
    }
    doubtful += differ;
  });
  return {mixed, static_cast<double>(doubtful) / (1.0 * before.width * before.height)};
}

}  // namespace keypose::composite
