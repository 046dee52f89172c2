// Pictures of several layers for compositing programs.
#pragma once

#include <filesystem>

#include "composite/scene/scene_plates.h"
#include "core/values/image.h"

namespace keypose::composite {

/// All of one size, in linear light of the plate's primaries. Empty ones are left out.
struct SceneLayers {
  ImageF light;      ///< RGB: the finished picture
  ImageF alpha;      ///< 1 channel: of it; empty: opaque
  ImageF character;  ///< RGBA, premultiplied: the character alone
  ImageF shadow;     ///< 1 channel, 0 to 1: the share of the plate's light that its shadow takes
  ImageF depth;      ///< 1 channel: along the camera's axis, in the shot's unit
};

/// Writes R G B A, character.R .G .B .A, mask.A (the character's), shadow.A and depth.Z into one
/// OpenEXR part with the plate's windows and chromaticities: half, but depth as float, and the
/// colours as float where the plate's are.
/// @throws DiskError
void WriteLayers(const std::filesystem::path& path, const SceneLayers& layers,
                 const ScenePlates& plates);

}  // namespace keypose::composite
