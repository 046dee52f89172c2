// Reads and writes images (JPEG, PNG, TIFF; HEIC is read; OpenEXR is written) and the EXIF that
// matters here, by OpenImageIO. What is read is told by its bytes (image_kind.h), is flat, has 1 to
// 4 channels and at most kMostPixels pixels.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "core/image.h"

namespace keypose {

struct ImageInfo {
  int width = 0, height = 0;  ///< after EXIF orientation is applied
  int channels = 0;
  int orientation = 1;  ///< EXIF orientation as stored; 1 for HEIC, whose own turn (irot, imir) the
                        ///< decoder has applied
  std::optional<double> focal_mm;
  std::optional<double> focal_35mm;       ///< FocalLengthIn35mmFilm
  std::optional<double> sensor_width_mm;  ///< from FocalPlaneXResolution where given
  std::string camera_model;               ///< "make model", may be empty
  std::string date_time;
  std::string format;  ///< "jpeg", "png", "tiff", "heif"
};

/// Header only.
/// @throws DiskError cannot be opened @throws InputError not an image of a known kind
ImageInfo ReadImageInfo(const std::filesystem::path& path);

/// Pixels with EXIF orientation applied, as 8 bit with `channels` (1: luma, 3: RGB; alpha is
/// dropped). 0 keeps 1 or 3.
/// @throws DiskError   cannot be opened; not enough memory
/// @throws InputError  not an image of a known kind, larger than kMostPixels, or truncated; names
/// the file
Image8 ReadImage(const std::filesystem::path& path, int channels = 0);

/// EXIF to write into a JPEG.
struct ExifToWrite {
  double focal_mm = 0, focal_35mm = 0;
  std::string make, model;
  int orientation = 1;
};
/// By extension; JPEG at `quality`.
/// @throws DiskError
void WriteImage(const std::filesystem::path& path, const Image8& image, int quality = 92,
                const ExifToWrite* exif = nullptr);

/// Whether WriteLinearImage knows the path's extension with this many bits a channel; 0: any that
/// the extension allows.
bool CanWriteLinear(const std::filesystem::path& path, int bits);
/// Linear light (1 is white) by extension. .exr keeps it linear, values above 1 too, as half (bits
/// 16, or 0) or float (32). .png and .tif are sRGB of 8 or 16 bits; 0 means 8 for .png and 16 for
/// .tif.
/// @throws UsageError  !CanWriteLinear(path, bits)
/// @throws DiskError
void WriteLinearImage(const std::filesystem::path& path, const ImageF& linear, int bits = 0);

/// The image shrunk (box filter per axis) or enlarged (bilinear) to width x height.
Image8 Resized(const Image8& image, int width, int height);

}  // namespace keypose
