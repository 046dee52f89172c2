// The pictures of a studio's plate or film, OpenEXR or DPX, as scene light.
#pragma once

#include <filesystem>
#include <string>

#include "composite/scene/light_file.h"
#include "composite/scene/plate_colors.h"
#include "core/values/camera.h"
#include "core/values/image.h"

namespace keypose::composite {

/// All pictures of a shot have one window and one kind of colours: those of the first.
class ScenePlates {
 public:
  /// @throws  as ReadLightHeader and PlateColors
  ScenePlates(const StatedColors& stated, const std::filesystem::path& first);

  const PictureWindow& window() const { return header_.window; }
  const PlateColors& colors() const { return colors_; }
  /// Whether pictures need 32 bits a channel to be stored again.
  bool single() const { return header_.single; }
  /// Channels of the first that are no colour, and are left out.
  int others() const { return header_.others; }

  /// What is learnt of a film looks at light between black and white. From now on all light is
  /// darker by as many whole stops as bring nearly all of this picture there, or brighter: a power
  /// of two, which changes no other bit. What is written is as bright as what was read.
  void ExposeFor(const std::filesystem::path& path);
  /// Factor on the light that is read.
  float exposure() const { return exposure_; }

  /// RGB in linear light of colors().primaries(), of the data window; not clamped.
  /// @throws InputError  another window or other colours than the first; as ReadLightValues
  ImageF Light(const std::filesystem::path& path) const;
  /// 1 channel, of the data window; empty: the picture has none.
  ImageF Alpha(const std::filesystem::path& path) const;

  /// To look at: sRGB, levels of 255. Highlights are compressed; what is not a number is black.
  /// @param light  RGB as of Light
  ImageF Shown(const ImageF& light) const;
  /// The whole picture (its display window) to look at; black where nothing is stored.
  Image8 ShownWhole(const std::filesystem::path& path) const;

  /// The camera of the data window.
  /// @param camera  of the display window
  /// @throws InputError  the camera is of pictures of another size
  Camera OfWindow(Camera camera) const;

 private:
  LightFile RequireAlike(const std::filesystem::path& path) const;

  std::string first_;
  LightFile header_;
  PlateColors colors_;
  float exposure_ = 1;
};

/// A picture of the display window in the data window; 0 where it has nothing.
Image8 InWindow(const Image8& whole, const PictureWindow& window);

}  // namespace keypose::composite
