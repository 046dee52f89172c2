// Points of a cloud sorted into small cells, those that face alike together.
#pragma once

#include <cstdint>
#include <vector>

#include "core/mesh.h"

namespace keypose::reconstruct {

/// A point and where it belongs: its cell, and the octant that its normal points into. Points with
/// one key stand side by side.
struct KeyedPoint {
  std::uint64_t key;
  int point;
};

/// All points, by key and then by number.
/// @param cloud  with normals
/// @param cell   side of a cell, in the cloud's unit. Keys have 20 bits an axis: beyond a million
/// cells a side they wrap Same order for any thread count.
std::vector<KeyedPoint> SortByFacingCell(const PointCloud& cloud, double cell);

}  // namespace keypose::reconstruct
