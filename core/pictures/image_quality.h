// Measures of the similarity of two images.
#pragma once

#include <cstdint>
#include <vector>

#include "core/values/image.h"

namespace keypose {

/// 0.299 R + 0.587 G + 0.114 B.
template <class T>
double Luma(const T* rgb) {
  return 0.299 * static_cast<double>(rgb[0]) + 0.587 * static_cast<double>(rgb[1]) +
         0.114 * static_cast<double>(rgb[2]);
}

/// Peak signal-to-noise ratio [dB]: 10 log10(255^2 / mean square), at most 99 (no difference); 0
/// when `count` is 0.
double Psnr(double sum_of_squares, double count);

/// Mean structural similarity over the valid pixels of two images of one channel (0..255): Gaussian
/// window 11 x 11 of standard deviation 1.5, K1 = 0.01, K2 = 0.03, L = 255. A window uses its valid
/// pixels only, and their weights are scaled to the sum 1. Where all pixels are valid this is the
/// usual index, with windows cut off at the border.
/// Source: Wang, Bovik, Sheikh, Simoncelli, IEEE TIP 13(4), 2004.
/// @param valid  one entry for each pixel
/// @pre both images have the same size
/// @return 1 where no pixel is valid.
/// Same bits for any thread count.
double Ssim(const ImageT<double>& a, const ImageT<double>& b, const std::vector<char>& valid);

}  // namespace keypose
