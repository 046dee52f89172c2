// How alike two images are.
#pragma once

#include <cstdint>
#include <vector>

#include "core/image.h"

namespace keypose {

/// 0.299 R + 0.587 G + 0.114 B.
template <class T>
double Luma(const T* rgb) {
  return 0.299 * static_cast<double>(rgb[0]) + 0.587 * static_cast<double>(rgb[1]) +
         0.114 * static_cast<double>(rgb[2]);
}

/// 10 log10(255^2 / mean square), at most 99 (no difference at all); 0 where nothing was counted.
double Psnr(double sum_of_squares, double count);

/// Mean structural similarity over the valid pixels of two images of one channel (0..255): Gaussian
/// window 11 x 11 of standard deviation 1.5, K1 = 0.01, K2 = 0.03, L = 255. A window counts its
/// valid pixels only, weights scaled to sum 1, so nothing else enters; where all are valid this is
/// the usual index, with windows cut at the border.
/// Source: Wang, Bovik, Sheikh, Simoncelli, IEEE TIP 13(4), 2004.
/// @param valid  one a pixel @pre both images of one size
/// @return 1 where no pixel is valid.
/// Same bits for any thread count.
double Ssim(const ImageT<double>& a, const ImageT<double>& b, const std::vector<char>& valid);

}  // namespace keypose
