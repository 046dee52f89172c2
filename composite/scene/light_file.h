// OpenEXR and DPX pictures as they are stored: header and values.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>

#include "core/values/image.h"

namespace keypose::composite {

/// What part of a picture is stored, in pixels: the data window in the display window's frame.
struct PictureWindow {
  int x = 0, y = 0, width = 0, height = 0;                      ///< of the data
  int full_x = 0, full_y = 0, full_width = 0, full_height = 0;  ///< of the display
  bool operator==(const PictureWindow&) const = default;
  bool whole() const {
    return x == full_x && y == full_y && width == full_width && height == full_height;
  }
};

struct LightFile {
  PictureWindow window;
  bool exr = false;     ///< else DPX
  bool single = false;  ///< stored as 32 bits a channel, which 16 do not hold
  int bits = 16;        ///< of DPX
  bool alpha = false;
  std::array<int, 4> channels{0, 1, 2, -1};  ///< where red, green, blue and alpha are
  std::optional<std::array<float, 8>> chromaticities;
  std::string transfer;  ///< of DPX: the transfer characteristic that its header states
  std::string writer;    ///< the program that wrote it, as far as it says
  int others = 0;        ///< channels that are no colour
};

/// OpenEXR or DPX, by content.
/// @throws DiskError  cannot be read
bool IsLightFile(const std::filesystem::path& path);

/// @throws InputError  damaged; several parts, deep pixels, no red, green and blue, whole
/// numbers in OpenEXR, pixels that are not square, larger than other pictures may be: names each
LightFile ReadLightHeader(const std::filesystem::path& path);

/// RGB, or RGBA where `alpha` is asked for, as stored: of DPX 0 to 1, of OpenEXR as they are.
/// @throws InputError  damaged or cut off
ImageF ReadLightValues(const std::filesystem::path& path, const LightFile& header, bool alpha);

}  // namespace keypose::composite
