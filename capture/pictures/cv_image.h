// Conversion between images of core and OpenCV's.
#pragma once

#include "core/values/image.h"

namespace cv {
class Mat;
}

namespace keypose::capture {

/// A read-only view of the same pixels; valid as long as the image is.
cv::Mat MatOf(const Image8& image);

/// A copy.
/// @param mat  8 bits per channel
Image8 ImageOf(const cv::Mat& mat);

}  // namespace keypose::capture
