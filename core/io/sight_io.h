// Lines of sight through the holes of a set's masks, read from its folders.
#pragma once

#include <vector>

#include "core/camera.h"
#include "core/io/image_set.h"
#include "core/sight_lines.h"

namespace keypose {

/// What the photographs see through the figure.
struct Sight {
  std::vector<View> views;    ///< that have a mask and a say; the lines count these
  std::vector<Image8> masks;  ///< of these views
  std::vector<SightLine> lines;
};

/// @throws InputError  a mask that cannot be read
Sight ReadSight(const ImageSet& set, const Scene& scene);

}  // namespace keypose
