#include "capture/shoot/develop/focus_stack.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>
#include <string>

#include "capture/pictures/cv_image.h"
#include "core/values/errors.h"

namespace keypose::capture::shoot {
namespace {

constexpr int kAlign_px = 640;  // longer side at which the photographs are aligned
constexpr int kCoarsest_px = 16;

void RequireStack(const std::vector<Image8>& images) {
  if (images.size() < 2) throw InputError("focus stack: two photographs at least are needed");
  for (const Image8& image : images)
    if (image.width != images[0].width || image.height != images[0].height || image.channels != 3)
      throw InputError("focus stack: its photographs differ in size; shoot them again");
}

cv::Mat SmallGrey(const Image8& image, double scale) {
  cv::Mat grey, small;
  cv::cvtColor(MatOf(image), grey, cv::COLOR_RGB2GRAY);
  cv::resize(grey, small, {}, scale, scale, cv::INTER_AREA);
  cv::GaussianBlur(small, small, {0, 0}, 2);  // what is in focus differs; large forms do not
  return small;
}

/// The photograph moved onto `reference`.
cv::Mat Aligned(const Image8& image, const cv::Mat& reference, double scale, std::size_t number) {
  cv::Mat warp = cv::Mat::eye(2, 3, CV_32F);
  const cv::TermCriteria until(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 60, 1e-5);
  double alike = 0;
  try {
    alike = cv::findTransformECC(reference, SmallGrey(image, scale), warp, cv::MOTION_AFFINE, until,
                                 cv::noArray(), 5);
  } catch (const cv::Exception&) {
    alike = 0;  // it does not converge on photographs of different things
  }
  constexpr double kAlike = 0.9;  // photographs of one stack reach 0.97
  if (alike < kAlike)
    throw InputError("focus stack: photograph " + std::to_string(number + 1) +
                     " does not show the same as the others; was the figure or the camera moved? "
                     "Shoot this angle again");
  warp.at<float>(0, 2) /= static_cast<float>(scale);
  warp.at<float>(1, 2) /= static_cast<float>(scale);
  cv::Mat moved;
  cv::warpAffine(MatOf(image), moved, warp, {image.width, image.height},
                 cv::INTER_LINEAR | cv::WARP_INVERSE_MAP, cv::BORDER_REPLICATE);
  return moved;
}

using Pyramid = std::vector<cv::Mat>;  // finest first; the last is what remains

Pyramid LaplacianOf(const cv::Mat& image) {
  Pyramid levels;
  cv::Mat at;
  image.convertTo(at, CV_32FC3);
  while (std::min(at.cols, at.rows) > kCoarsest_px) {
    cv::Mat smaller, back;
    cv::pyrDown(at, smaller);
    cv::pyrUp(smaller, back, at.size());
    levels.push_back(at - back);
    at = smaller;
  }
  levels.push_back(at);
  return levels;
}

cv::Mat EnergyOf(const cv::Mat& level) {
  cv::Mat grey, smooth;
  cv::cvtColor(level, grey, cv::COLOR_RGB2GRAY);
  grey = grey.mul(grey);
  cv::GaussianBlur(grey, smooth, {5, 5}, 1.2);
  return smooth;
}

/// Keeps in `best` what has more energy in `level`.
void TakeSharper(const cv::Mat& level, cv::Mat& best, cv::Mat& energy) {
  const cv::Mat own = EnergyOf(level);
  const cv::Mat sharper = own > energy;
  level.copyTo(best, sharper);
  own.copyTo(energy, sharper);
}

cv::Mat Collapsed(const Pyramid& levels) {
  cv::Mat at = levels.back();
  for (auto level = levels.rbegin() + 1; level != levels.rend(); ++level) {
    cv::Mat back;
    cv::pyrUp(at, back, level->size());
    at = back + *level;
  }
  return at;
}

}  // namespace

Image8 MergeFocusStack(const std::vector<Image8>& images) {
  RequireStack(images);
  const int longer = std::max(images[0].width, images[0].height);
  const double scale = std::min(1.0, static_cast<double>(kAlign_px) / longer);
  const std::size_t middle = images.size() / 2;
  const cv::Mat reference = SmallGrey(images[middle], scale);
  Pyramid best;
  std::vector<cv::Mat> energy;
  for (std::size_t i = 0; i < images.size(); ++i) {
    const cv::Mat moved =
        i == middle ? MatOf(images[i]).clone() : Aligned(images[i], reference, scale, i);
    const Pyramid levels = LaplacianOf(moved);
    if (best.empty()) {
      for (const cv::Mat& level : levels) {
        best.push_back(level.clone());
        energy.push_back(EnergyOf(level));
      }
      continue;
    }
    for (std::size_t l = 0; l + 1 < levels.size(); ++l) TakeSharper(levels[l], best[l], energy[l]);
    best.back() += levels.back();
  }
  best.back() /= static_cast<double>(images.size());
  cv::Mat merged;
  Collapsed(best).convertTo(merged, CV_8UC3);
  return ImageOf(merged);
}

}  // namespace keypose::capture::shoot
