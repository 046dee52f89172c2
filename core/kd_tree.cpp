#include "core/kd_tree.h"

#include <algorithm>
#include <limits>
#include <nanoflann.hpp>
#include <numeric>
#include <tuple>

#include "core/errors.h"

namespace keypose {

struct KdTree::Impl {
  using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, Impl>, Impl, 3, std::size_t>;

  explicit Impl(const PointsX3& p) : points(p), tree(3, *this, nanoflann::KDTreeSingleIndexAdaptorParams(16)) {
    // The points of a leaf lie side by side in memory from now on.
    index.swap(tree.vAcc);
    for (std::size_t i = 0; i < index.size(); ++i) points.row(static_cast<Eigen::Index>(i)) = p.row(static_cast<Eigen::Index>(index[i]));
    tree.vAcc.resize(index.size());
    std::iota(tree.vAcc.begin(), tree.vAcc.end(), std::size_t{0});
  }
  std::size_t kdtree_get_point_count() const { return static_cast<std::size_t>(points.rows()); }
  double kdtree_get_pt(std::size_t i, std::size_t d) const { return points(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(d)); }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
  Neighbor NeighborAt(std::size_t i, double squared) const { return {static_cast<int>(index[i]), squared}; }

  PointsX3 points;                 // in the order of the leaves
  std::vector<std::size_t> index;  // of each, in the input
  Tree tree;                       // built when it is made
};

namespace {

/// What nanoflann asks of a set of results, for just one.
class Closest {
 public:
  bool addPoint(double squared, std::size_t i) {
    if (squared < squared_) squared_ = squared, at_ = i;
    return true;
  }
  double worstDist() const { return squared_; }
  bool full() const { return true; }
  std::size_t at() const { return at_; }

 private:
  double squared_ = std::numeric_limits<double>::max();
  std::size_t at_ = 0;
};

}  // namespace

KdTree::KdTree(const PointsX3& points) {
  if (points.rows() == 0) throw InputError("nearest neighbours: there are no points");
  impl_ = std::make_unique<Impl>(points);
}
KdTree::~KdTree() = default;
KdTree::KdTree(KdTree&&) noexcept = default;

KdTree::Neighbor KdTree::Nearest(const Eigen::Vector3d& point) const {
  Closest closest;
  impl_->tree.findNeighbors(closest, point.data(), nanoflann::SearchParams());
  return impl_->NeighborAt(closest.at(), closest.worstDist());
}

std::vector<KdTree::Neighbor> KdTree::Nearest(const Eigen::Vector3d& point, int k) const {
  const auto count = static_cast<std::size_t>(std::min<Eigen::Index>(k, impl_->points.rows()));
  std::vector<std::size_t> indices(count);
  std::vector<double> squared(count);
  nanoflann::KNNResultSet<double> result(count);
  result.init(indices.data(), squared.data());
  impl_->tree.findNeighbors(result, point.data(), nanoflann::SearchParams());
  std::vector<Neighbor> neighbors(count);
  for (std::size_t i = 0; i < count; ++i) neighbors[i] = impl_->NeighborAt(indices[i], squared[i]);
  return neighbors;
}

std::vector<KdTree::Neighbor> KdTree::Within(const Eigen::Vector3d& point, double radius) const {
  std::vector<std::pair<std::size_t, double>> found;
  impl_->tree.radiusSearch(point.data(), radius * radius, found, nanoflann::SearchParams(32, 0, false));
  for (auto& near : found) near.first = impl_->index[near.first];
  // Equal distances are ordered by index, so that the order never depends on the tree.
  std::sort(found.begin(), found.end(),
            [](const auto& a, const auto& b) { return std::tie(a.second, a.first) < std::tie(b.second, b.first); });
  std::vector<Neighbor> neighbors;
  neighbors.reserve(found.size());
  for (const auto& [index, squared] : found) neighbors.push_back({static_cast<int>(index), squared});
  return neighbors;
}

}  // namespace keypose
