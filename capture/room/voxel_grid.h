// Samples of depths gathered in a sparse grid of voxels, so that all of a surface counts alike.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "capture/room/coarse_depths.h"

namespace keypose::capture {

/// The samples in one voxel.
struct Voxel {
  Eigen::Vector3i at;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  Eigen::Vector3f outward = Eigen::Vector3f::Zero(), colour = Eigen::Vector3f::Zero();
  int count = 0;
  int first_view = -1;
  bool several = false;  ///< more views than one show it

  Eigen::Vector3d Point() const { return sum / count; }
};

class VoxelGrid {
 public:
  /// @param side   of a voxel
  /// @param reach  samples that are farther from the middle are left out
  VoxelGrid(const CoarseDepths& depths, const Eigen::Vector3d& middle, double side, double reach);

  double side() const { return side_; }
  /// In the order of their first samples.
  const std::vector<Voxel>& voxels() const { return voxels_; }
  /// Index of the voxel that holds the point; -1: none.
  int Find(const Eigen::Vector3d& x) const { return FindAt(CellOf(x)); }
  int FindAt(const Eigen::Vector3i& at) const;

 private:
  Eigen::Vector3i CellOf(const Eigen::Vector3d& x) const;
  void Add(const DepthSample& sample, int view);

  Eigen::Vector3d middle_;
  double side_;
  std::vector<Voxel> voxels_;
  std::unordered_map<std::int64_t, int> index_;
};

}  // namespace keypose::capture
