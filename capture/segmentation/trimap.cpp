#include "capture/segmentation/trimap.h"

#include <opencv2/imgproc.hpp>

#include "capture/pictures/cv_image.h"

namespace keypose::capture {

Image8 TrimapOf(const Image8& mask) {
  const cv::Mat kernel = cv::getStructuringElement(cv::MORPH_ELLIPSE, {5, 5});
  cv::Mat inside, outside;
  cv::erode(MatOf(mask), inside, kernel);
  cv::dilate(MatOf(mask), outside, kernel);
  cv::Mat trimap(inside.size(), CV_8U, cv::Scalar(kUnknown));
  trimap.setTo(kObject, inside);
  trimap.setTo(kBackground, outside == 0);
  return ImageOf(trimap);
}

}  // namespace keypose::capture
