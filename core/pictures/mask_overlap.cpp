#include "core/pictures/mask_overlap.h"

#include <cstddef>
#include <cstdint>

namespace keypose {

double MaskIoU(const Image8& a, const Image8& b, double of_empty) {
  std::int64_t both = 0, either = 0;
  for (std::size_t i = 0; i < a.data.size(); ++i) {
    const bool in_a = a.data[i] > 127, in_b = b.data[i] > 127;
    both += in_a && in_b;
    either += in_a || in_b;
  }
  return either == 0 ? of_empty : static_cast<double>(both) / static_cast<double>(either);
}

}  // namespace keypose
