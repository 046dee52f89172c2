// Limbs that stand wrongly turned, looked for and turned right.
#pragma once

#include <vector>

#include "core/values/progress.h"
#include "fit/limbs/limb_pictures.h"

namespace keypose::fit {

struct TurnedLimbs {
  PointsX3 points;           ///< V x 3
  std::vector<char> turned;  ///< V: 1 for the vertices of limbs that were turned
  int count = 0;             ///< of these limbs
};

/// Turns limbs that the photographs contradict, at three joints each: in many ways, then the best
/// of these improved, and again around the best. A limb stays where it is unless the photographs
/// agree clearly better.
/// @param rest    V x 3, the shape before it was bent
/// @param colors  V x 3, of the vertices (VertexColors)
/// @param now     V x 3, where the vertices stand
/// @throws Cancelled
/// Same bits for any thread count. Cost: 2 s of processor time for a limb that is looked for.
/// See docs/algorithms/fit.md.
TurnedLimbs TurnLimbs(const PointsX3& rest, const FacesX3& faces, const Eigen::MatrixX3f& colors,
                      const std::vector<SmallPicture>& pictures, const PointsX3& now,
                      Progress* progress = nullptr);

}  // namespace keypose::fit
