// A decoded frame as a picture of 8 bits.
#pragma once

extern "C" {
#include <libavutil/frame.h>
}

#include "core/values/image.h"

namespace keypose {

/// Whether the frame says of its pixels how opaque they are.
bool HasAlpha(const AVFrame& frame);

/// The frame as it is stored, not turned. Each value is rounded once; colour that is stored for
/// every other pixel is interpolated between them by where the frame says that it lies.
/// @param channels  3 (RGB) or 4 (RGB and alpha as stored; 255 where the frame has none)
/// Precondition: ColorFault(frame) is empty.
Image8 PixelsOf(const AVFrame& frame, int channels);

}  // namespace keypose
