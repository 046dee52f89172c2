// Assumed labels of a photograph's pixels before segmentation.
#pragma once

#include <cstdint>

#include "core/values/image.h"

namespace keypose::capture {

/// Values of a trimap: one channel, of its photograph's size.
enum TrimapLabel : std::uint8_t { kUnknown = 0, kBackground = 1, kObject = 2 };

/// The trimap of a mask; the mixed pixels at its border are unknown.
Image8 TrimapOf(const Image8& mask);

}  // namespace keypose::capture
