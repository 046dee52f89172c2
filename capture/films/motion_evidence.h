// What motion says of each colour of a pixel: the set's, or of something that moves before it.
#pragma once

#include <vector>

#include "capture/films/pixel_modes.h"
#include "core/values/image.h"

namespace keypose::capture {

/// For each pixel and mode, from -1 (the set) to 1 (something that moves before it), from edges: a
/// thing before the set has its edge where the picture has one, and the set's usual picture has
/// none; where a thing stood still for most of the film it is the other way round.
/// @param lab  the frames from which the modes were found
/// @return kMostModes values for each pixel; 0: nothing is known
std::vector<float> EdgeEvidence(const std::vector<Image8>& lab, const PixelModes& modes,
                                const Image8& area, double radius);

/// The same from texture: where a patch has texture and keeps its values from one frame to the next
/// it stands still, as the set does; where they change as much as the texture does, it moves.
std::vector<float> TextureEvidence(const std::vector<Image8>& lab, const PixelModes& modes,
                                   const Image8& area, double radius);

}  // namespace keypose::capture
