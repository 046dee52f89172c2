// Reads and writes images and the EXIF data that Keypose needs, by OpenImageIO. Reads JPEG, PNG,
// TIFF and HEIC; writes JPEG, PNG, TIFF and OpenEXR. The content of a file decides its format
// (image_kind.h). Images must be flat (not volumes), with 1 to 4 channels and at most kMostPixels
// pixels.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "core/values/image.h"

namespace keypose {

struct ImageInfo {
  int width = 0, height = 0;  ///< after EXIF orientation is applied
  int channels = 0;
  int orientation = 1;  ///< EXIF orientation as stored; 1 for HEIC, because the decoder applies the
                        ///< container's rotation (irot, imir)
  std::optional<double> focal_mm;
  std::optional<double> focal_35mm;       ///< FocalLengthIn35mmFilm
  std::optional<double> sensor_width_mm;  ///< from FocalPlaneXResolution where given
  std::string camera_model;               ///< "make model", may be empty
  std::string date_time;
  std::string format;  ///< "jpeg", "png", "tiff", "heif"
};

/// Reads the header only.
/// @throws DiskError cannot be opened @throws InputError not an image of a known kind
ImageInfo ReadImageInfo(const std::filesystem::path& path);

/// The pixels as 8 bit, with the EXIF orientation applied. `channels` is 1 (luma), 3 (RGB) or 0,
/// which keeps 1 or 3. Alpha is dropped; luma is multiplied by it. Colours with an ICC profile become sRGB; luma is that of the
/// colours as they are stored.
/// @throws DiskError   cannot be opened; not enough memory
/// @throws InputError  not an image of a known kind, larger than kMostPixels, or truncated; names
/// the file
Image8 ReadImage(const std::filesystem::path& path, int channels = 0);

/// The RGB pixels as they lie in the file, which the coordinates of a mesh address: EXIF does not
/// turn them. For the rest as ReadImage.
Image8 ReadTexture(const std::filesystem::path& path);

/// The alpha channel alone, as 8 bit, or an empty image where there is none. For the rest as
/// ReadImage. HEIF pictures count as without.
Image8 ReadAlpha(const std::filesystem::path& path);

/// EXIF to write into a JPEG.
struct ExifToWrite {
  double focal_mm = 0, focal_35mm = 0;
  std::string make, model;
  int orientation = 1;
};
/// Writes the image in the format of the path's extension; JPEG with `quality`.
/// @throws DiskError
void WriteImage(const std::filesystem::path& path, const Image8& image, int quality = 92,
                const ExifToWrite* exif = nullptr);

/// Whether WriteLinearImage can write this extension with this many bits per channel. 0: the
/// extension's default.
bool CanWriteLinear(const std::filesystem::path& path, int bits);
/// Writes linear light (1 is white) in the format of the path's extension. .exr keeps linear
/// values, also those above 1, as half (bits 16 or 0) or float (32). .png and .tif are written as
/// sRGB with 8 or 16 bits; 0 means 8 for .png and 16 for .tif.
/// @throws UsageError  !CanWriteLinear(path, bits)
/// @throws DiskError
void WriteLinearImage(const std::filesystem::path& path, const ImageF& linear, int bits = 0);

/// The image resized to width x height, by a box filter where it shrinks and bilinearly where it
/// grows, separately for each axis.
Image8 Resized(const Image8& image, int width, int height);
/// The same of a mask: 255 where it is above 127, else 0.
Image8 ResizedMask(const Image8& mask, int width, int height);

}  // namespace keypose
