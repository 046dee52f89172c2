// A photograph as a camera gives it: JPEG, TIFF, PNG, HEIC or RAW.
#pragma once

#include <array>
#include <filesystem>

#include "core/io/pictures/image_io.h"
#include "core/values/image.h"

namespace keypose::capture::shoot {

/// How an exposure was made, from EXIF; 0 where unknown.
struct ExposureSettings {
  double exposure_s = 0;
  double aperture = 0;  ///< f-number
  double iso = 0;
  double focal_mm = 0, focal_35mm = 0;
};

/// By ReadRaw or core's ReadImage. RGB.
/// @throws DiskError, InputError
Image8 ReadPhotograph(const std::filesystem::path& file);
ImageInfo ReadPhotographInfo(const std::filesystem::path& file);
/// Nothing is thrown for a file without EXIF.
/// @throws DiskError, InputError
ExposureSettings ReadSettings(const std::filesystem::path& file);

}  // namespace keypose::capture::shoot
