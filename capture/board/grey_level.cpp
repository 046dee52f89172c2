#include "capture/board/grey_level.h"

#include <algorithm>
#include <cstdint>
#include <opencv2/core.hpp>

namespace keypose::capture {

double LevelAt(const cv::Mat& grey, double x, double y) {
  x = std::clamp(x, 0.0, grey.cols - 1.001);
  y = std::clamp(y, 0.0, grey.rows - 1.001);
  const int ix = static_cast<int>(x), iy = static_cast<int>(y);
  const double u = x - ix, v = y - iy;
  const std::uint8_t* top = grey.ptr(iy) + ix;
  const std::uint8_t* low = grey.ptr(iy + 1) + ix;
  return (1 - v) * ((1 - u) * top[0] + u * top[1]) + v * ((1 - u) * low[0] + u * low[1]);
}

}  // namespace keypose::capture
