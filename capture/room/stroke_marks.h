// What of a room's surface lies under a person's strokes.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "capture/room/stroke_masks.h"
#include "capture/room/voxel_grid.h"
#include "core/values/camera.h"

namespace keypose::capture {

/// Indices of voxels; a voxel that strokes of several photographs mark is listed for each.
struct StrokeMarks {
  std::vector<int> figure, other;
  Eigen::Vector3d sight =
      Eigen::Vector3d::Zero();  ///< the mean direction in which the other things are seen
};

/// The nearest voxels that the photographs show under strokes: other photographs tell their depth
/// where the marked one could not be matched.
/// @param strokes  by view, or empty
StrokeMarks MarksOf(const VoxelGrid& grid, const std::vector<View>& views,
                    const std::vector<ViewStrokes>& strokes);

}  // namespace keypose::capture
