// Masks of many frames in little memory.
#pragma once

#include <cstdint>
#include <vector>

#include "core/values/image.h"

namespace keypose::motion {

/// A mask as lengths of runs of equal pixels, row by row; the first run is of zeros. A person's
/// mask of 500 x 500 pixels takes a few kilobytes.
class MaskRuns {
 public:
  /// @param mask  one channel of 0 and 1
  explicit MaskRuns(const Image8& mask);
  /// The same mask again.
  Image8 Mask() const;
  std::int64_t bytes() const;

 private:
  int width_, height_;
  std::vector<std::uint32_t> runs_;
};

}  // namespace keypose::motion
