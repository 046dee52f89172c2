// Pictures with all the levels that their files store: those of 16 bits are not rounded to 8. For
// pictures that are mixed and written again; what only looks at pictures reads them by image_io.h.
#pragma once

#include <filesystem>
#include <string>

#include "core/values/image.h"
#include "core/values/image16.h"

namespace keypose {

struct ExifToWrite;  // image_io.h

/// How a file stores its pixels.
struct StoredLevels {
  int bits = 8;         ///< per channel; those of HEIC count as 8, which is what its decoder gives
  bool alpha = false;   ///< there is an alpha channel
  std::string profile;  ///< ICC colour profile; empty: none
};
/// Reads the header only; throws as ReadImageInfo.
StoredLevels StoredLevelsOf(const std::filesystem::path& path);

/// Stored values as levels of 255, with fractions where there are more than 8 bits; the EXIF
/// orientation is applied. Pictures of 8 bits give whole numbers. Alpha is left out, and colours
/// are those in the file: a PNG's are not multiplied by it.
/// @param channels  1 (luma) or 3 (RGB)
/// Throws as ReadImage.
ImageF ReadLevels(const std::filesystem::path& path, int channels = 3);

/// Writes levels of 255 (clamped and rounded) as PNG or TIFF, by the path's extension: grey, RGB,
/// or RGB with straight alpha.
/// @param bits     8 or 16
/// @param profile  ICC profile of the colours; empty: sRGB
/// @throws DiskError
void WriteLevels(const std::filesystem::path& path, const ImageF& levels, int bits,
                 const std::string& profile = {});

/// A photograph as RGB with the levels of its file. One of the two is empty.
struct StoredPicture {
  Image8 eight;
  Image16 sixteen;  ///< where the file has more than 8 bits a channel
};
/// As ReadImage (upright, in sRGB, without alpha), but more than 8 bits are kept, as 16.
StoredPicture ReadAsStored(const std::filesystem::path& path);

/// As WriteImage, with 16 bits where the format has them; JPEG has 8, rounded.
void WriteImage(const std::filesystem::path& path, const Image16& image, int quality = 92,
                const ExifToWrite* exif = nullptr);

Image16 Resized(const Image16& image, int width, int height);

}  // namespace keypose
