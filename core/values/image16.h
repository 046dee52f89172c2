// Pictures of 16 bits per channel.
#pragma once

#include <cstdint>

#include "core/values/image.h"

namespace keypose {

using Image16 = ImageT<std::uint16_t>;  ///< sRGB; 65535 is white

}  // namespace keypose
