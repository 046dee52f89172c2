#include "capture/segmentation/guided_filter.h"

#include <opencv2/core.hpp>

#include "core/values/late_library.h"

namespace keypose::capture {
namespace {

LateLibrary filter_library("guided_filter", "refine masks");

}  // namespace

void GuidedFilter(const cv::Mat& guide, const cv::Mat& in, int radius, double noise, cv::Mat* out) {
  using Filter = void (*)(const cv::Mat&, const cv::Mat&, int, double, cv::Mat*);
  reinterpret_cast<Filter>(filter_library.Find("KeyposeGuidedFilter"))(guide, in, radius, noise,
                                                                       out);
}

}  // namespace keypose::capture
