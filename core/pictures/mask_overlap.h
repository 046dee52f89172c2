// How well two masks agree.
#pragma once

#include "core/values/image.h"

namespace keypose {

/// Pixels in both over pixels in either; values above 127 count.
/// @param a, b      of one size, 1 channel
/// @param of_empty  returned when both are empty
double MaskIoU(const Image8& a, const Image8& b, double of_empty = 0);

}  // namespace keypose
