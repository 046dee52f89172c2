// The pictures of a vertex animation texture, as files in memory.
#pragma once

#include <cstdint>
#include <string>

#include "core/values/image.h"

namespace keypose::exporting {

/// Each has three channels. The values are data, not colours: no file says a colour space.
/// @throws ToolError  OpenImageIO cannot write the file
std::string PngOf8Bits(const Image8& image);
std::string PngOf16Bits(const ImageT<std::uint16_t>& image);
/// Single precision, with ZIP compression, which loses nothing.
std::string ExrOfFloats(const ImageF& image);

}  // namespace keypose::exporting
