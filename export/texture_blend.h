// How much each pose's texture shows at each time of the animation.
#pragma once

#include <vector>

#include "export/playback.h"

namespace keypose::exporting {

/// Weights at a time; between two of them all is linear.
struct TextureMoment {
  double seconds = 0;
  std::vector<double> weights;  ///< one a texture; they sum to 1
};

/// @param t            key number plus share of the way to the next
/// @param key_textures of each key on the timeline: which texture is its own, below `count`
/// @return one weight a texture
std::vector<double> TextureWeights(double t, const std::vector<int>& key_textures, int count);

/// From key to key the weights go over as the shape does; where pictures stand, so do weights.
///
/// @param keyframes  as LinearKeyframes gives them
/// @param frame_t    of each frame
/// @return the moments that are needed: what lies on the line between its neighbours is left out
std::vector<TextureMoment> TextureMoments(const std::vector<Keyframe>& keyframes,
                                          const std::vector<double>& frame_t,
                                          const std::vector<int>& key_textures, int count);

}  // namespace keypose::exporting
