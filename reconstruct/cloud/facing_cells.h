// Points of a cloud sorted by small cells and by the direction of their normals.
#pragma once

#include <cstdint>
#include <vector>

#include "core/values/mesh.h"

namespace keypose::reconstruct {

/// A point and its key: its cell, and the octant of its normal. Points with the same key are
/// adjacent after sorting.
struct KeyedPoint {
  std::uint64_t key;
  int point;
};

/// All points, by key and then by index.
/// @param cloud  with normals
/// @param cell   side of a cell, in the cloud's unit. Keys have 20 bits per axis: beyond a million
/// cells per side they wrap.
/// Same order for any thread count.
std::vector<KeyedPoint> SortByFacingCell(const PointCloud& cloud, double cell);

}  // namespace keypose::reconstruct
