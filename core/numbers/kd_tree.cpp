#include "core/numbers/kd_tree.h"

#include <algorithm>
#include <nanoflann.hpp>
#include <tuple>

#include "core/values/errors.h"

namespace keypose {

struct KdTree::Impl {
  using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, Impl>, Impl,
                                                   3, std::size_t>;

  explicit Impl(const PointsX3& p)
      : points(p), tree(3, *this, nanoflann::KDTreeSingleIndexAdaptorParams(16)) {}
  std::size_t kdtree_get_point_count() const { return static_cast<std::size_t>(points.rows()); }
  double kdtree_get_pt(std::size_t i, std::size_t d) const {
    return points(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(d));
  }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }

  PointsX3 points;
  Tree tree;  // built when it is made
};

KdTree::KdTree(const PointsX3& points) {
  if (points.rows() == 0) throw InputError("nearest neighbours: there are no points");
  impl_ = std::make_unique<Impl>(points);
}
KdTree::~KdTree() = default;
KdTree::KdTree(KdTree&&) noexcept = default;

KdTree::Neighbor KdTree::Nearest(const Eigen::Vector3d& point) const {
  std::size_t at = 0;
  double squared = 0;
  nanoflann::KNNResultSet<double> result(1);
  result.init(&at, &squared);
  impl_->tree.findNeighbors(result, point.data(), nanoflann::SearchParams());
  return {static_cast<int>(at), squared};
}

std::vector<KdTree::Neighbor> KdTree::Nearest(const Eigen::Vector3d& point, int k) const {
  const auto count = static_cast<std::size_t>(std::min<Eigen::Index>(k, impl_->points.rows()));
  std::vector<std::size_t> indices(count);
  std::vector<double> squared(count);
  nanoflann::KNNResultSet<double> result(count);
  result.init(indices.data(), squared.data());
  impl_->tree.findNeighbors(result, point.data(), nanoflann::SearchParams());
  std::vector<Neighbor> neighbors(count);
  for (std::size_t i = 0; i < count; ++i) neighbors[i] = {static_cast<int>(indices[i]), squared[i]};
  return neighbors;
}

std::vector<KdTree::Neighbor> KdTree::Within(const Eigen::Vector3d& point, double radius) const {
  std::vector<std::pair<std::size_t, double>> found;
  impl_->tree.radiusSearch(point.data(), radius * radius, found,
                           nanoflann::SearchParams(32, 0, false));
  // Neighbours at equal distances are ordered by index, so the order does not depend on the tree.
  std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) {
    return std::tie(a.second, a.first) < std::tie(b.second, b.first);
  });
  std::vector<Neighbor> neighbors;
  neighbors.reserve(found.size());
  for (const auto& [index, squared] : found)
    neighbors.push_back({static_cast<int>(index), squared});
  return neighbors;
}

}  // namespace keypose
