// The finished pictures of a shot whose plates are scene light.
#pragma once

#include <filesystem>

#include "composite/composing/compose.h"
#include "composite/composite_input.h"

namespace keypose::composite {

/// One picture with its layers (WriteLayers). The plate's alpha goes through.
/// @param animation  its frame
void WriteScenePicture(const std::filesystem::path& path, const CompositeInput& input,
                       const ComposedPicture& composed, int animation);
/// A plate alone.
void WriteScenePlate(const std::filesystem::path& path, const CompositeInput& input,
                     const ImageF& light);
/// Textures as they were before they became light of the plate's primaries.
ImageF TextureInRec709(const CompositeInput& input, const ImageF& texture);

}  // namespace keypose::composite
