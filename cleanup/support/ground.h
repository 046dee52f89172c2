// The ground under a figure that stands: soles that no photograph shows are cut flat on it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/camera.h"
#include "core/image.h"
#include "core/mesh.h"

namespace keypose::cleanup {

struct Standing {
  bool stands = false;
  double contact = 0;  ///< height at which the outlines end, along z
  std::string why;     ///< it does not stand, in words
};

/// Whether the figure stands on z = 0 and nothing was seen of what the surface has below: its
/// outlines must end there to 1 % of the height, no camera may look up from below, no photograph
/// may show the surface there, and what lies there must be less than a sixth of the height.
///
/// @param surface  in the cameras' frame, z up
/// @param masks    one a view, 1 channel, above 127 where the figure is; empty for a view without
/// say; of any size of the view's shape
Standing StandsOnGround(const Mesh& surface, const std::vector<View>& views,
                        const std::vector<Image8>& masks);

}  // namespace keypose::cleanup
