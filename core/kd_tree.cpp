#include "core/kd_tree.h"

#include <algorithm>
#include <array>
#include <limits>
#include <nanoflann.hpp>
#include <numeric>
#include <tuple>

#include "core/errors.h"

namespace keypose {

struct KdTree::Impl {
  using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, Impl>, Impl,
                                                   3, std::size_t>;

  explicit Impl(const PointsX3& p)
      : points(p), tree(3, *this, nanoflann::KDTreeSingleIndexAdaptorParams(16)) {
    // The points of a leaf lie side by side in memory from now on.
    index.swap(tree.vAcc);
    for (std::size_t i = 0; i < index.size(); ++i) points.row(i) = p.row(index[i]);
    tree.vAcc.resize(index.size());
    std::iota(tree.vAcc.begin(), tree.vAcc.end(), std::size_t{0});
  }
  std::size_t kdtree_get_point_count() const { return static_cast<std::size_t>(points.rows()); }
  double kdtree_get_pt(std::size_t i, std::size_t d) const {
    return points(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(d));
  }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
  Neighbor NeighborAt(std::size_t i, double squared) const {
    return {static_cast<int>(index[i]), squared};
  }
  Neighbor Closest(const Eigen::Vector3d& point) const;
  Neighbor ClosestByNanoflann(
      const Eigen::Vector3d& point) const;  ///< of trees deeper than any sensible one

  PointsX3 points;                 // in the order of the leaves
  std::vector<std::size_t> index;  // of each, in the input
  Tree tree;                       // built when it is made
};

/// nanoflann's own search for one neighbour, the same places in the same order, but without a call
/// for each node.
KdTree::Neighbor KdTree::Impl::Closest(const Eigen::Vector3d& point) const {
  struct Branch {
    const Tree::Node* node;
    double squared;       // from the point to the node's box
    Eigen::Vector3d own;  // of that, along each axis
  };
  constexpr int kDeepest = 96;
  std::array<Branch, kDeepest> open;
  Branch now{tree.root_node, 0, Eigen::Vector3d::Zero()};
  for (int k = 0; k < 3; ++k) {
    const double off =
        std::max({tree.root_bbox[k].low - point[k], point[k] - tree.root_bbox[k].high, 0.0});
    now.own[k] = off * off;
    now.squared += now.own[k];
  }
  double least = std::numeric_limits<double>::max();
  std::size_t at = 0;
  for (int waiting = 0;;) {
    while (now.node->child1) {
      const auto& cut = now.node->node_type.sub;
      const double before = point[cut.divfeat] - cut.divlow,
                   after = point[cut.divfeat] - cut.divhigh;
      const bool first = before + after < 0;
      const double across = first ? after : before;
      if (waiting == kDeepest) return ClosestByNanoflann(point);
      Branch& other = open[waiting++] = now;
      other.node = first ? now.node->child2 : now.node->child1;
      other.squared = other.squared + across * across - now.own[cut.divfeat];
      other.own[cut.divfeat] = across * across;
      now.node = first ? now.node->child1 : now.node->child2;
    }
    for (std::size_t i = now.node->node_type.lr.left; i < now.node->node_type.lr.right; ++i) {
      const double* const p = points.data() + 3 * i;
      const double x = point[0] - p[0], y = point[1] - p[1], z = point[2] - p[2],
                   squared = x * x + y * y + z * z;
      if (squared < least) least = squared, at = i;
    }
    do {
      if (waiting == 0) return NeighborAt(at, least);
      now = open[--waiting];
    } while (!(now.squared <= least));
  }
}

KdTree::Neighbor KdTree::Impl::ClosestByNanoflann(const Eigen::Vector3d& point) const {
  std::size_t at = 0;
  double squared = 0;
  nanoflann::KNNResultSet<double> result(1);
  result.init(&at, &squared);
  tree.findNeighbors(result, point.data(), nanoflann::SearchParams());
  return NeighborAt(at, squared);
}

KdTree::KdTree(const PointsX3& points) {
  if (points.rows() == 0) throw InputError("nearest neighbours: there are no points");
  impl_ = std::make_unique<Impl>(points);
}
KdTree::~KdTree() = default;
KdTree::KdTree(KdTree&&) noexcept = default;

KdTree::Neighbor KdTree::Nearest(const Eigen::Vector3d& point) const {
  return impl_->Closest(point);
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
  impl_->tree.radiusSearch(point.data(), radius * radius, found,
                           nanoflann::SearchParams(32, 0, false));
  for (auto& near : found) near.first = impl_->index[near.first];
  // Equal distances are ordered by index, so that the order never depends on the tree.
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
