#include "capture/pictures/cv_image.h"

#include <opencv2/core.hpp>

namespace keypose::capture {

cv::Mat MatOf(const Image8& image) {
  return cv::Mat(image.height, image.width, CV_8UC(image.channels),
                 const_cast<std::uint8_t*>(image.data.data()));
}

Image8 ImageOf(const cv::Mat& mat) {
  Image8 image(mat.cols, mat.rows, mat.channels());
  mat.copyTo(MatOf(image));
  return image;
}

}  // namespace keypose::capture
