// Grey levels between the pixels of a board's picture.
#pragma once

namespace cv {
class Mat;
}

namespace keypose::capture {

/// Bilinear between pixels; their centres are at whole numbers. Places outside are clamped.
/// @param grey  8 bits, one channel, at least 2 x 2
double LevelAt(const cv::Mat& grey, double x, double y);

}  // namespace keypose::capture
