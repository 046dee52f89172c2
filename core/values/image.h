// 8-bit and float images as plain row-major, interleaved arrays.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace keypose {

template <class T>
struct ImageT {
  int width = 0, height = 0, channels = 0;
  std::vector<T> data;  ///< (y * width + x) * channels + c; top row first

  ImageT() = default;
  ImageT(int w, int h, int c, T fill = T{})
      : width(w), height(h), channels(c), data(static_cast<std::size_t>(w) * h * c, fill) {}
  T* at(int x, int y) { return data.data() + (static_cast<std::size_t>(y) * width + x) * channels; }
  const T* at(int x, int y) const {
    return data.data() + (static_cast<std::size_t>(y) * width + x) * channels;
  }
  bool empty() const { return data.empty(); }
};
using Image8 = ImageT<std::uint8_t>;  ///< sRGB when it has 3 channels; a mask or grey when it has 1
using ImageF = ImageT<float>;

}  // namespace keypose
