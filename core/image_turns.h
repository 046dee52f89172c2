// Rotation of whole pictures.
#pragma once

#include "core/image.h"

namespace keypose {

/// The picture rotated by 180 degrees. Any number of channels.
Image8 TurnedOver(const Image8& image);
/// Rotated by 90 degrees, clockwise.
Image8 QuarterTurned(const Image8& image);

}  // namespace keypose
