// RAW files of cameras, developed by LibRaw through OpenImageIO.
#pragma once

#include <filesystem>

#include "core/io/pictures/image_io.h"
#include "core/values/image.h"

namespace keypose {

/// The pixels as sRGB with the camera's white balance, upright; no automatic brightness, so that
/// all photographs of a set keep their exposure.
/// @throws DiskError   cannot be opened; not enough memory
/// @throws InputError  no RAW file that LibRaw knows, or damaged; names the file
Image8 ReadRaw(const std::filesystem::path& file);

/// Reads the header only; width and height as ReadRaw gives them.
/// @throws DiskError, InputError  as above
ImageInfo ReadRawInfo(const std::filesystem::path& file);

}  // namespace keypose
