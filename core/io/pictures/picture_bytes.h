// Pictures that lie inside of other files, such as the textures of a glTF: read from bytes, and
// written to bytes. By libpng, libjpeg and libwebp alone, so that programs start fast.
#pragma once

#include <string>
#include <string_view>

#include "core/values/image.h"

namespace keypose {

/// "png", "jpeg" or "webp", judged by the first bytes; "" for anything else.
std::string PictureBytesKind(std::string_view bytes);

/// The pixels as 8 bit RGB, as they are stored: no EXIF orientation, and alpha is left out.
/// @param name  of the picture, for messages
/// @throws InputError  no PNG, JPEG or WebP, damaged, or of more than kMostPixels pixels
Image8 DecodePicture(std::string_view bytes, const std::string& name);

/// A PNG file of an image of 1 (grey) or 3 (sRGB) channels.
/// @throws DiskError  it cannot be held in memory
std::string PngBytes(const Image8& image);

}  // namespace keypose
