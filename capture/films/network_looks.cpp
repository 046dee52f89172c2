#include "capture/films/network_looks.h"

#include <algorithm>
#include <cstdlib>
#include <opencv2/imgproc.hpp>

#include "capture/films/pixel_modes.h"
#include "capture/pictures/cv_image.h"

namespace keypose::capture {
namespace {

constexpr double kLookMargin = 1.15;   // of the square about the actor
constexpr double kAlike = 0.7;         // least overlap of opinion and mask
constexpr double kHalfForgotten = 10;  // frames after which an opinion counts half
// In twenty frames of a real film: of what was wrongly taken for the actor the network was sure
// that it is not in a half, of the actor in 2 %; sure that it is in 5 % and 80 %.
constexpr float kYes = 2, kNo = -6;

cv::Rect SquareAbout(const cv::Mat& mask) {
  const cv::Rect box = cv::boundingRect(mask);
  const int side = static_cast<int>(kLookMargin * std::max(box.width, box.height));
  const cv::Rect square(box.x + (box.width - side) / 2, box.y + (box.height - side) / 2, side,
                        side);
  return square & cv::Rect({0, 0}, mask.size());
}

double Overlap(const cv::Mat& a, const cv::Mat& b) {
  const int either = cv::countNonZero(a | b);
  return either > 0 ? static_cast<double>(cv::countNonZero(a & b)) / either : 0;
}

/// The middle values say nothing.
float WeightOf(std::uint8_t salience) {
  constexpr int kSure = 200, kSureNot = 20;
  if (salience > kSure) return kYes;
  return salience < kSureNot ? kNo : 0;
}

}  // namespace

bool NetworkLooks::Add(int frame, const Image8& rgb, const Image8& lab, const Image8& mask,
                       const AskNetwork& network) {
  const cv::Mat actor = MatOf(mask) > 127;
  if (cv::countNonZero(actor) == 0) return false;
  const cv::Rect square = SquareAbout(actor);
  const Image8 seen = network(ImageOf(MatOf(rgb)(square)));
  if (Overlap(MatOf(seen) > 127, actor(square)) < kAlike) return false;
  cv::Mat whole(actor.size(), CV_8U, cv::Scalar(127));
  MatOf(seen).copyTo(whole(square));
  const auto at =
      std::lower_bound(looks_.begin(), looks_.end(), frame,
                       [](const NetworkLook& look, int number) { return look.frame < number; });
  looks_.insert(at, {frame, lab, ImageOf(whole)});
  return true;
}

ImageF NetworkLooks::Odds(int frame, const Image8& lab, double radius) const {
  ImageF odds(lab.width, lab.height, 1), weights(lab.width, lab.height, 1);
  const auto after =
      std::lower_bound(looks_.begin(), looks_.end(), frame,
                       [](const NetworkLook& look, int number) { return look.frame < number; });
  const auto add = [&](const NetworkLook& look) {
    const double age = std::abs(look.frame - frame);
    const auto weight = static_cast<float>(1 / (1 + age / kHalfForgotten));
    for (std::size_t p = 0; p < odds.data.size(); ++p) {
      if (ModeDistance(&lab.data[3 * p], &look.lab.data[3 * p]) > radius) continue;
      odds.data[p] += weight * weight * WeightOf(look.salience.data[p]);
      weights.data[p] += weight;
    }
  };
  if (after != looks_.end()) add(*after);
  const bool here = after != looks_.end() && after->frame == frame;
  if (!here && after != looks_.begin()) add(*(after - 1));
  for (std::size_t p = 0; p < odds.data.size(); ++p)
    if (weights.data[p] > 0) odds.data[p] /= weights.data[p];
  return odds;
}

}  // namespace keypose::capture
