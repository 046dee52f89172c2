#include "capture/room/voxel_grid.h"

#include <cstddef>

#include "core/values/size_of.h"

namespace keypose::capture {
namespace {

std::int64_t KeyOf(const Eigen::Vector3i& at) {
  constexpr std::int64_t kOffset = 1 << 20;
  return ((at.x() + kOffset) << 42) | ((at.y() + kOffset) << 21) | (at.z() + kOffset);
}

}  // namespace

VoxelGrid::VoxelGrid(const CoarseDepths& depths, const Eigen::Vector3d& middle, double side,
                     double reach)
    : middle_(middle), side_(side) {
  for (std::size_t v = 0; v < depths.views.size(); ++v)
    for (const DepthSample& sample : depths.views[v]) {
      if ((sample.point - middle).norm() > reach) continue;
      Add(sample, static_cast<int>(v));
    }
}

int VoxelGrid::FindAt(const Eigen::Vector3i& at) const {
  const auto found = index_.find(KeyOf(at));
  return found == index_.end() ? -1 : found->second;
}

Eigen::Vector3i VoxelGrid::CellOf(const Eigen::Vector3d& x) const {
  return ((x - middle_) / side_).array().floor().cast<int>();
}

void VoxelGrid::Add(const DepthSample& sample, int view) {
  const Eigen::Vector3i at = CellOf(sample.point);
  const auto [found, added] = index_.try_emplace(KeyOf(at), SizeOf(voxels_));
  if (added) {
    voxels_.emplace_back();
    voxels_.back().at = at;
    voxels_.back().first_view = view;
  }
  Voxel& voxel = voxels_[static_cast<std::size_t>(found->second)];
  voxel.sum += sample.point;
  voxel.outward += sample.outward;
  voxel.colour += sample.colour;
  ++voxel.count;
  voxel.several = voxel.several || voxel.first_view != view;
}

}  // namespace keypose::capture
