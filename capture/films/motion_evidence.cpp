#include "capture/films/motion_evidence.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "capture/pictures/cv_image.h"
#include "core/numbers/parallel.h"

namespace keypose::capture {
namespace {

/// What lies beside the border of what moves in one frame.
class Border {
 public:
  /// @param steady  how steadily each pixel shows its usual colour, in [0, 1]: beside a pixel that
  /// often shows another, the usual picture may be the actor
  Border(const Image8& lab, const Image8& usual, const cv::Mat& steady, const cv::Mat& moving,
         double radius)
      : lab_(lab), usual_(usual), steady_(steady), moving_(moving), radius_(radius) {
    sum_ = cv::Mat::zeros(moving.size(), CV_32F);
    count_ = sum_.clone();
    for (int y = kBeside; y + kBeside < moving.rows; ++y)
      for (int x = kBeside; x + kBeside < moving.cols; ++x) Add(x, y);
  }

  /// Evidence that each pixel shows a thing before the set, near the border.
  cv::Mat Spread() const {
    const int window = 2 * std::max(2, std::max(moving_.rows, moving_.cols) / 170) + 1;
    cv::Mat near_sum, near_count, result(moving_.size(), CV_32F);
    for (const bool inside : {true, false}) {
      cv::Mat side = inside ? cv::Mat(moving_ != 0) : cv::Mat(moving_ == 0), sum, count;
      cv::Mat weight;
      side.convertTo(weight, CV_32F, 1 / 255.0);
      cv::boxFilter(sum_.mul(weight), near_sum, CV_32F, {window, window}, {-1, -1}, false);
      cv::boxFilter(count_.mul(weight), near_count, CV_32F, {window, window}, {-1, -1}, false);
      for (int y = 0; y < result.rows; ++y)
        for (int x = 0; x < result.cols; ++x)
          if (side.at<std::uint8_t>(y, x))
            result.at<float>(y, x) = near_sum.at<float>(y, x) / (near_count.at<float>(y, x) + 2);
    }
    return result;
  }

 private:
  static constexpr int kBeside = 2;  // pixels on the border mix both sides

  void Add(int x, int y) {
    const bool here = moving_.at<std::uint8_t>(y, x) != 0;
    for (const auto& [dx, dy] : {cv::Point(1, 0), cv::Point(0, 1)}) {
      if ((moving_.at<std::uint8_t>(y + dy, x + dx) != 0) == here) continue;
      const int ax = x - dx, ay = y - dy, bx = x + 2 * dx, by = y + 2 * dy;
      const double edge = ModeDistance(lab_.at(ax, ay), lab_.at(bx, by)),
                   usual = ModeDistance(usual_.at(ax, ay), usual_.at(bx, by));
      const auto value = static_cast<float>(std::clamp((edge - usual) / (2 * radius_), -1.0, 1.0));
      const float weight = here ? steady_.at<float>(by, bx) : steady_.at<float>(ay, ax);
      Put(x, y, here ? value : -value, weight);
      Put(x + dx, y + dy, here ? -value : value, weight);
    }
  }
  void Put(int x, int y, float value, float weight) {
    sum_.at<float>(y, x) += weight * value;
    count_.at<float>(y, x) += weight;
  }

  const Image8 &lab_, &usual_;
  const cv::Mat &steady_, &moving_;
  double radius_;
  cv::Mat sum_, count_;
};

cv::Mat Steadiness(const PixelModes& modes) {
  constexpr double kUnsteady = 0.55, kSteady = 0.9;  // share of frames with the usual colour
  cv::Mat steady(modes.height, modes.width, CV_32F);
  for (std::size_t p = 0; p < steady.total(); ++p)
    steady.ptr<float>()[p] = static_cast<float>(
        std::clamp((modes.of(p)->share / 255.0 - kUnsteady) / (kSteady - kUnsteady), 0.0, 1.0));
  return steady;
}

Image8 UsualPicture(const PixelModes& modes) {
  Image8 usual(modes.width, modes.height, 3);
  for (std::size_t p = 0; p < usual.data.size() / 3; ++p)
    std::copy_n(modes.of(p)->lab.begin(), 3, &usual.data[3 * p]);
  return usual;
}

/// Each frame's evidence goes to the modes that its pixels have in it.
std::vector<float> SumOverFrames(const std::vector<cv::Mat>& evidence, const PixelModes& modes,
                                 const Image8& area) {
  std::vector<float> sums(modes.modes.size(), 0);
  for (std::size_t k = 0; k < evidence.size(); ++k)
    for (std::size_t p = 0; p < area.data.size(); ++p)
      if (const std::uint8_t mode = modes.labels[k].data[p]; area.data[p] && mode != kNoMode)
        sums[p * kMostModes + mode] += evidence[k].ptr<float>()[p];
  for (float& sum : sums) sum = sum / (std::abs(sum) + 1.0F);
  return sums;
}

/// Mean difference of a pixel to the next in its row and column, over a window.
cv::Mat Texture(const Image8& lab) {
  cv::Mat texture = cv::Mat::zeros(lab.height, lab.width, CV_32F);
  for (int y = 0; y + 1 < lab.height; ++y)
    for (int x = 0; x + 1 < lab.width; ++x)
      texture.at<float>(y, x) =
          static_cast<float>(0.5 * (ModeDistance(lab.at(x, y), lab.at(x + 1, y)) +
                                    ModeDistance(lab.at(x, y), lab.at(x, y + 1))));
  cv::boxFilter(texture, texture, CV_32F, {5, 5});
  return texture;
}

cv::Mat Change(const Image8& a, const Image8& b) {
  cv::Mat change(a.height, a.width, CV_32F);
  for (std::size_t p = 0; p < change.total(); ++p)
    change.ptr<float>()[p] = static_cast<float>(ModeDistance(&a.data[3 * p], &b.data[3 * p]));
  cv::boxFilter(change, change, CV_32F, {5, 5});
  return change;
}

/// From -1, textured and still, to 1, changed as much as the texture.
cv::Mat Moves(const cv::Mat& texture, const cv::Mat& change, double radius) {
  constexpr float kStill = 0.35F;  // of the texture: smaller changes are noise
  const auto least = static_cast<float>(0.4 * radius);
  cv::Mat moves(texture.size(), CV_32F);
  for (std::size_t p = 0; p < moves.total(); ++p) {
    const float has = texture.ptr<float>()[p], changed = change.ptr<float>()[p];
    const float trust = has / (has + least);
    moves.ptr<float>()[p] =
        trust *
        std::clamp((changed - kStill * (has + least)) / (kStill * (has + least)), -1.0F, 1.0F);
  }
  return moves;
}

}  // namespace

std::vector<float> EdgeEvidence(const std::vector<Image8>& lab, const PixelModes& modes,
                                const Image8& area, double radius) {
  const Image8 usual = UsualPicture(modes);
  const cv::Mat steady = Steadiness(modes);
  std::vector<cv::Mat> evidence(lab.size());
  ParallelFor(std::ssize(lab), [&](std::int64_t k) {
    cv::Mat moving = cv::Mat::zeros(modes.height, modes.width, CV_8U);
    const Image8& label = modes.labels[k];
    for (std::size_t p = 0; p < moving.total(); ++p)
      if (area.data[p] && label.data[p] != 0) moving.data[p] = 255;
    cv::medianBlur(moving, moving, 3);
    evidence[k] = Border(lab[k], usual, steady, moving, radius).Spread();
  });
  return SumOverFrames(evidence, modes, area);
}

std::vector<float> TextureEvidence(const std::vector<Image8>& lab, const PixelModes& modes,
                                   const Image8& area, double radius) {
  if (lab.size() < 2) return std::vector<float>(modes.modes.size(), 0);
  std::vector<cv::Mat> evidence(lab.size());
  ParallelFor(std::ssize(lab), [&](std::int64_t k) {
    const std::size_t next = k + 1 < std::ssize(lab) ? k + 1 : k - 1;
    evidence[k] = Moves(Texture(lab[k]), Change(lab[k], lab[next]), radius);
  });
  return SumOverFrames(evidence, modes, area);
}

}  // namespace keypose::capture
