#include "capture/pictures/working_image.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "capture/pictures/cv_image.h"

namespace keypose::capture {

Image8 WorkingImage(const Image8& image, int working_px) {
  const double factor = static_cast<double>(working_px) / std::max(image.width, image.height);
  if (factor >= 1) return image;
  cv::Mat small;
  const cv::Size size(std::max(1, static_cast<int>(std::lround(image.width * factor))),
                      std::max(1, static_cast<int>(std::lround(image.height * factor))));
  cv::resize(MatOf(image), small, size, 0, 0, cv::INTER_AREA);
  return ImageOf(small);
}

Image8 EnlargedMask(const Image8& mask, int eighths, int width, int height) {
  Image8 enlarged(width, height, 1);
  cv::Mat large;
  if (8 % eighths == 0) {
    // The mask's last column and row may reach beyond the picture.
    const int times = 8 / eighths;
    cv::resize(MatOf(mask), large, {mask.width * times, mask.height * times}, 0, 0,
               cv::INTER_LINEAR);
    large = large(cv::Rect(0, 0, width, height));
  } else {
    const double part = eighths / 8.0;
    const cv::Matx23d place(part, 0, part / 2 - 0.5, 0, part, part / 2 - 0.5);
    cv::warpAffine(MatOf(mask), large, place, {width, height},
                   cv::INTER_LINEAR | cv::WARP_INVERSE_MAP, cv::BORDER_REPLICATE);
  }
  cv::threshold(large, MatOf(enlarged), 127, 255, cv::THRESH_BINARY);
  return enlarged;
}

Image8 Grey(const Image8& image) {
  cv::Mat grey;
  cv::cvtColor(MatOf(image), grey, cv::COLOR_RGB2GRAY);
  return ImageOf(grey);
}

double MaskFraction(const Image8& mask) {
  std::size_t inside = 0;
  for (const std::uint8_t m : mask.data) inside += m > 127;
  return mask.data.empty() ? 0
                           : static_cast<double>(inside) / static_cast<double>(mask.data.size());
}

}  // namespace keypose::capture
