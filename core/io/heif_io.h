// Pixels of HEIC photographs, by libheif itself: OpenImageIO copies as many of a row as the
// container claims, whatever was decoded.
#pragma once

#include <filesystem>

#include "core/image.h"

namespace keypose {

/// The primary picture as 8 bit RGB, turned as its container says (irot, imir).
/// @throws InputError  truncated or damaged, also where the container claims another size than the
/// picture has; names the file
Image8 ReadHeif(const std::filesystem::path& path);

}  // namespace keypose
