// Sizes of containers as signed numbers.
#pragma once

#include <iterator>

namespace keypose {

/// Number of items as an int, like the indices of meshes and images.
template <class Items>
int SizeOf(const Items& items) {
  return static_cast<int>(std::size(items));
}

}  // namespace keypose
