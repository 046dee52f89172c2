// Decides whether a figure stands on the ground z = 0, so that its soles, which no photograph
// shows, can be cut flat.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/values/camera.h"
#include "core/values/image.h"
#include "core/values/mesh.h"

namespace keypose::cleanup {

/// What is known of z = 0.
enum class GroundKind {
  kGuessed,  ///< where outlines or points seem to end
  kBoard,    ///< the printed calibration board
  kFloor     ///< a plane of points that the masks take for what the figure stands on
};

struct Standing {
  bool stands = false;
  double contact = 0;  ///< height along z at which the outlines end
  std::string why;     ///< why it does not stand; for the user
};

/// Whether the figure stands on z = 0 and no photograph shows the part of the surface below. The
/// conditions are: the outlines end at z = 0 to 1 % of the height, no camera looks up from below,
/// photographs do not show surface below z = 0, and that surface reaches down by less than a sixth
/// of the height.
///
/// @param surface  in the cameras' frame, z up
/// @param masks  one for each view: 1 channel, above 127 where the figure is, of any size with the
/// view's aspect ratio; empty: the view is ignored
/// @param kind  below the printed calibration board nothing can be: outlines that end up to 3 % of
/// the height below it are too large there, as in a dark contact shadow. Of a floor, below which
/// the masks have nothing either, it is only asked that no camera looks up from below
Standing StandsOnGround(const Mesh& surface, const std::vector<View>& views,
                        const std::vector<Image8>& masks, GroundKind kind = GroundKind::kGuessed);

}  // namespace keypose::cleanup
