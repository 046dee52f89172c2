// The module keypose_guided_filter: guided_filter.h by OpenCV.
#include <opencv2/core.hpp>
#include <opencv2/ximgproc/edge_filter.hpp>

extern "C" __attribute__((visibility("default"))) void KeyposeGuidedFilter(const cv::Mat& guide,
                                                                           const cv::Mat& in,
                                                                           int radius, double noise,
                                                                           cv::Mat* out) {
  cv::ximgproc::guidedFilter(guide, in, *out, radius, noise);
}
