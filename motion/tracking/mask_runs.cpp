#include "motion/tracking/mask_runs.h"

#include <algorithm>

#include "core/values/size_of.h"

namespace keypose::motion {

MaskRuns::MaskRuns(const Image8& mask) : width_(mask.width), height_(mask.height) {
  std::uint8_t value = 0;
  for (auto at = mask.data.begin(); at != mask.data.end(); value ^= 1) {
    const auto end = std::find(at, mask.data.end(), value ^ 1);
    runs_.push_back(static_cast<std::uint32_t>(end - at));
    at = end;
  }
  runs_.shrink_to_fit();
}

Image8 MaskRuns::Mask() const {
  Image8 mask(width_, height_, 1);
  auto at = mask.data.begin();
  std::uint8_t value = 0;
  for (const std::uint32_t run : runs_) {
    std::fill_n(at, run, value);
    at += run;
    value ^= 1;
  }
  return mask;
}

std::int64_t MaskRuns::bytes() const { return SizeOf(runs_) * sizeof(std::uint32_t); }

}  // namespace keypose::motion
