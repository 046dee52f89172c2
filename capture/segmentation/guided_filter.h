// The guided filter, He, Sun and Tang, "Guided Image Filtering", 2013. Of OpenCV's ximgproc, which
// links some 120 libraries of pictures and maps and is therefore loaded when it is needed.
#pragma once

namespace cv {
class Mat;
}

namespace keypose::capture {

/// @param guide     three channels of 8 bits
/// @param in        one channel, of the guide's size
/// @param radius    pixels
/// @param noise     of the guide, squared levels: smaller changes are no edges
/// @throws ToolError  OpenCV's ximgproc cannot be loaded
void GuidedFilter(const cv::Mat& guide, const cv::Mat& in, int radius, double noise, cv::Mat* out);

}  // namespace keypose::capture
