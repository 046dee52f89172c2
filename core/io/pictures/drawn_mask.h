// Masks as a person drew them or another program wrote them: white on black, any two levels, a
// label of 1, alpha.
#pragma once

#include <filesystem>
#include <string>

#include "core/values/image.h"

namespace keypose {

/// 255 where the figure is, else 0, by the levels of a file.
///
/// Of two levels the higher one is the figure, however small both are; with more, what is above
/// half of 255. One level alone is nothing at 0, and everything above. Lossy levels up to 8 alone
/// are black with noise.
/// @param levels    H x W x 1, of 255, with fractions where a file stores more than 8 bits
/// @param lossless  false: levels near 0 and 255 are noise of the compression
/// @param name      of the file, for messages
/// @throws InputError  several labels, a trimap, a mask that is dark all over: which level is meant
/// cannot be known
Image8 MaskOfLevels(const ImageF& levels, bool lossless, const std::string& name);

/// The mask in a file, 255 or 0: by its alpha where that differs between pixels or hides all of
/// them, else by its levels. The EXIF orientation is applied.
/// @throws InputError  as MaskOfLevels; a picture in colours @throws DiskError as ReadImage
Image8 ReadDrawnMask(const std::filesystem::path& path);

/// Whether a file keeps each level as it was painted: JPEG and HEIF do not.
/// @throws InputError, DiskError as ReadImageInfo
bool KeepsLevels(const std::filesystem::path& path);

}  // namespace keypose
