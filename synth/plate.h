// The ChArUco plate that may lie under the character.
#pragma once

#include <vector>

#include "core/image.h"
#include "core/mesh.h"
#include "synth/photographer.h"

namespace keypose::synth {

/// A board of OpenCV's DICT_5X5_100 in the plane z = 0, centred on the axis; x to the right and y up when seen from above.
struct Plate {
  Image8 picture;  ///< grey, first row at +y; covers width_m x height_m
  double width_m = 0, height_m = 0;
  double border_m = 0;  ///< white card round the board
  PointsX3 corners;     ///< inner chessboard corners in OpenCV's order of ids, in world [m], z = 0
};

/// @throws UsageError  marker not smaller than the square, or more markers than the dictionary has
Plate MakePlate(const PlateOptions& options);

}  // namespace keypose::synth
