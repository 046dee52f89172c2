// Selects fewer points for an adjustment, spread over the object.
#pragma once

#include <vector>

#include "reconstruct/bundle/bundle_adjustment.h"

namespace keypose::reconstruct {

/// A scene's points and their observations.
struct PointSet {
  Scene scene;
  std::vector<Observation> observations;  ///< of scene.points
};

/// At most `count` of the points, in their order. In turns, each cell of a grid over the object
/// contributes its point with most views. More than some thousand points improve an adjustment
/// little and cost much.
PointSet SpreadPoints(const Scene& scene, const std::vector<Observation>& observations, int count);

/// The points for which `keep` is not 0, in their order.
PointSet KeepPoints(const Scene& scene, const std::vector<Observation>& observations,
                    const std::vector<char>& keep);

}  // namespace keypose::reconstruct
