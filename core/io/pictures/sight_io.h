// Reads the masks of an image set and finds the lines of sight through their holes.
#pragma once

#include <vector>

#include "core/io/pictures/image_set.h"
#include "core/pictures/sight_lines.h"
#include "core/values/camera.h"

namespace keypose {

/// The lines of sight through the figure.
struct Sight {
  std::vector<View> views;    ///< trusted views with a mask; SightLine::view is an index into these
  std::vector<Image8> masks;  ///< of these views; of 2000 pixels or a little more where larger
  std::vector<SightLine> lines;
};

/// The views and masks alone, without lines.
/// @throws InputError  a mask that cannot be read
Sight ReadMaskedViews(const ImageSet& set, const Scene& scene);

/// @throws InputError  a mask that cannot be read
Sight ReadSight(const ImageSet& set, const Scene& scene);

}  // namespace keypose
