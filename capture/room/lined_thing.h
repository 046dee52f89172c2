// Which part of a connected surface is a thing that touches the figure, by a person's line over it.
#pragma once

#include <vector>

#include "capture/room/stroke_marks.h"
#include "capture/room/support_planes.h"
#include "capture/room/voxel_grid.h"

namespace keypose::capture {

/// The thing is about as wide as the line over it, and behind it; of a few widths the one is taken
/// that leaves the cheapest border (see piece_split.h). Where nothing of the figure is marked, its
/// upper end is the figure.
/// @param piece   indices of the voxels of figure and thing
/// @param height  [world] of the figure's highest point above its support
/// @return for each of the piece's voxels 1 if it is the thing's; empty where the marks tell
/// nothing Same bits for any thread count.
std::vector<char> OtherThingIn(const VoxelGrid& grid, const std::vector<int>& piece,
                               const StrokeMarks& marks, const Support& support, double height);

}  // namespace keypose::capture
