// Nearest neighbours among points (a kd-tree by nanoflann).
#pragma once

#include <memory>
#include <vector>

#include "core/values/mesh.h"

namespace keypose {

/// An immutable set of points, ready for queries from many threads.
class KdTree {
 public:
  struct Neighbor {
    int index = -1;
    double squared_distance = 0;
  };
  /// @throws InputError  no points
  explicit KdTree(const PointsX3& points);
  ~KdTree();
  KdTree(KdTree&&) noexcept;

  Neighbor Nearest(const Eigen::Vector3d& point) const;
  /// The k nearest (fewer if there are fewer points), nearest first.
  std::vector<Neighbor> Nearest(const Eigen::Vector3d& point, int k) const;
  /// All within `radius`, nearest first.
  std::vector<Neighbor> Within(const Eigen::Vector3d& point, double radius) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace keypose
