#include "capture/segmentation/guided_filter.h"

#include "core/values/late_library.h"

namespace keypose::capture {
namespace {

LateLibrary filter_library("guided_filter", "KeyposeGuidedFilter", "refine masks");

}  // namespace

void GuidedFilter(const cv::Mat& guide, const cv::Mat& in, int radius, double noise, cv::Mat* out) {
  using Filter = void (*)(const cv::Mat&, const cv::Mat&, int, double, cv::Mat*);
  reinterpret_cast<Filter>(filter_library.Entry())(guide, in, radius, noise, out);
}

}  // namespace keypose::capture
