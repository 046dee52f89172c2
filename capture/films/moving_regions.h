// Where something moves in a fixed camera's film, and which of the things that move is the actor.
#pragma once

#include <string>
#include <vector>

#include "capture/films/pixel_modes.h"
#include "core/values/image.h"

namespace keypose::capture {

/// A place in which things move, in all frames together.
struct MovingRegion {
  Image8 area;  ///< 255 inside, holes filled
  double amount =
      0;  ///< sum over its pixels of the share of frames with another than the usual colour
  int left = 0, top = 0, right = 0, bottom = 0;  ///< its box [px]; right and bottom are exclusive
};

/// The regions, the one with most motion first. A pixel moves if it has another than its most
/// frequent colour for more than a few frames; noise and specks are left out.
std::vector<MovingRegion> FindMovingRegions(const PixelModes& modes);

/// "at the left edge", "in the middle", "at the top right", ...
std::string PlaceOf(const MovingRegion& region, int width, int height);

}  // namespace keypose::capture
