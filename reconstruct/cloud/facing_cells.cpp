#include "reconstruct/cloud/facing_cells.h"

#include <algorithm>

#include "core/numbers/parallel.h"

namespace keypose::reconstruct {

std::vector<KeyedPoint> SortByFacingCell(const PointCloud& cloud, double cell) {
  constexpr std::int64_t kGrain = 4096;
  const Eigen::RowVector3d low = cloud.points.colwise().minCoeff();
  std::vector<KeyedPoint> keyed(cloud.points.rows());
  ParallelBlocks(cloud.points.rows(), kGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) {
      std::uint64_t key = 0;
      for (int c = 0; c < 3; ++c)
        key = key << 20 |
              (static_cast<std::uint64_t>((cloud.points(i, c) - low[c]) / cell) & 0xFFFFF);
      for (int c = 0; c < 3; ++c) key = key << 1 | (cloud.normals(i, c) > 0 ? 1 : 0);
      keyed[i] = {key, static_cast<int>(i)};
    }
  });
  std::sort(keyed.begin(), keyed.end(), [](const KeyedPoint& a, const KeyedPoint& b) {
    return a.key != b.key ? a.key < b.key : a.point < b.point;
  });
  return keyed;
}

}  // namespace keypose::reconstruct
