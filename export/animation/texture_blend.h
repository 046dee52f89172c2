// The weight of each pose's texture at each time of the animation.
#pragma once

#include <vector>

#include "export/animation/playback.h"

namespace keypose::exporting {

/// The weights at a time; linear in between.
struct TextureMoment {
  double seconds = 0;
  std::vector<double> weights;  ///< one per texture; they sum to 1
};

/// @param t            key number plus share of the way to the next
/// @param key_textures per key of the timeline: the index of its texture, below `count`
/// @return one weight per texture
std::vector<double> TextureWeights(double t, const std::vector<int>& key_textures, int count);

/// Between keys the weights change in step with the shape; while a picture is held, so are its
/// weights.
///
/// @param keyframes  as returned by LinearKeyframes
/// @param frame_t    t of each frame, as in TextureWeights
/// @return the moments, without those that lie on the line between their neighbours
std::vector<TextureMoment> TextureMoments(const std::vector<Keyframe>& keyframes,
                                          const std::vector<double>& frame_t,
                                          const std::vector<int>& key_textures, int count);

}  // namespace keypose::exporting
