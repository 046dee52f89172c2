// Fewer points for an adjustment, spread over the object.
#pragma once

#include <vector>

#include "reconstruct/bundle/bundle_adjustment.h"

namespace keypose::reconstruct {

/// A scene's points and where views show them.
struct PointSet {
  Scene scene;
  std::vector<Observation> observations;  ///< of scene.points
};

/// At most `count` of the points, in their order: from each cell of a grid over the object the
/// points that most views show, cell after cell in turns. What an adjustment gains from more points
/// than some thousand is little against what they cost.
PointSet SpreadPoints(const Scene& scene, const std::vector<Observation>& observations, int count);

/// The points for which `keep` is not 0, in their order.
PointSet KeepPoints(const Scene& scene, const std::vector<Observation>& observations,
                    const std::vector<char>& keep);

}  // namespace keypose::reconstruct
