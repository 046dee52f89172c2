// Images of core as OpenCV's, and back.
#pragma once

#include "core/image.h"

namespace cv {
class Mat;
}

namespace keypose::capture {

/// The same pixels; valid as long as the image is, and read only.
cv::Mat MatOf(const Image8& image);

/// A copy.
/// @param mat  8 bits a channel
Image8 ImageOf(const cv::Mat& mat);

}  // namespace keypose::capture
