// Whether a set of photographs stands in a room, and what the sparse points tell of the masks.
#pragma once

#include <vector>

#include "core/values/camera.h"
#include "core/values/image.h"

namespace keypose::capture {

struct RoomOptions {
  double around = 0.2;  ///< least share of the points outside of the masks, in a room
  double thickness =
      0.01;            ///< of the cameras' distance: points of the floor lie within this of z = 0
  double reach = 0.6;  ///< and at most so far from the origin
  int fewest = 30;     ///< points of a floor
  double floor_share = 0.1;  ///< and of the points within reach
  double on_floor = 0.03;    ///< share of the masks' points on the floor from which masks hold some
};

struct RoomEvidence {
  double around = 0;     ///< share of the points that most of their views see outside of the masks
  bool floor = false;    ///< z = 0 carries points around the origin: what the figure stands on
  double on_floor = 0;   ///< share of the points inside of the masks that lie on the floor
  bool in_room = false;  ///< points are all around, not on the figure alone
  bool floor_in_masks = false;  ///< the masks hold pieces of what the figure stands on
};

/// @param scene  views with cameras of the masks' size, and the points that placed them
/// @param masks  by view
RoomEvidence LookAround(const Scene& scene, const std::vector<Image8>& masks,
                        const RoomOptions& options = {});

}  // namespace keypose::capture
