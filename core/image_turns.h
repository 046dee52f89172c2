// Turns of whole pictures.
#pragma once

#include "core/image.h"

namespace keypose {

/// The picture turned by 180 degrees; any number of channels.
Image8 TurnedOver(const Image8& image);

}  // namespace keypose
