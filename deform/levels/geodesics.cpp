#include "deform/levels/geodesics.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>
#include <tuple>
#include <utility>

#include "core/numbers/kd_tree.h"
#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "deform/levels/step_queue.h"

namespace keypose {

namespace {

struct Arc {
  int from, to;
  double length;
};

/// An edge and the two corners opposite to it (-1 when there is none; further faces of a
/// non-manifold edge are ignored).
struct SharedEdge {
  int a, b, left, right;
};

std::vector<SharedEdge> EdgesAlone(const FacesX3& faces) {
  std::vector<SharedEdge> edges;
  for (const auto& [a, b] : UndirectedEdges(faces))
    if (a != b) edges.push_back({a, b, -1, -1});
  return edges;
}

std::vector<SharedEdge> SharedEdges(const FacesX3& faces) {
  struct Side {
    int a, b, opposite;
  };
  std::vector<Side> sides;
  sides.reserve(static_cast<std::size_t>(3 * faces.rows()));
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    for (int k = 0; k < 3; ++k) {
      const int a = faces(f, k), b = faces(f, (k + 1) % 3);
      if (a != b) sides.push_back({std::min(a, b), std::max(a, b), faces(f, (k + 2) % 3)});
    }
  std::sort(sides.begin(), sides.end(), [](const Side& s, const Side& t) {
    return std::tie(s.a, s.b, s.opposite) < std::tie(t.a, t.b, t.opposite);
  });
  std::vector<SharedEdge> edges;
  for (const Side& side : sides) {
    if (edges.empty() || edges.back().a != side.a || edges.back().b != side.b)
      edges.push_back({side.a, side.b, side.opposite, -1});
    else if (edges.back().right < 0)
      edges.back().right = side.opposite;
  }
  return edges;
}

/// Length of the straight line from `left` to `right` across the edge after both faces are unfolded
/// into one plane. Infinite when the line misses the edge.
double UnfoldedLength(const SharedEdge& edge, const PointsX3& points) {
  const Eigen::RowVector3d along = points.row(edge.b) - points.row(edge.a);
  const double length = along.norm();
  if (!(length > 0)) return std::numeric_limits<double>::infinity();
  const auto flat = [&](int vertex) {
    const Eigen::RowVector3d d = points.row(vertex) - points.row(edge.a);
    const double x = d.dot(along) / length;
    return Eigen::Vector2d(x, std::sqrt(std::max(0.0, d.squaredNorm() - x * x)));
  };
  const Eigen::Vector2d l = flat(edge.left), r = flat(edge.right);
  const double height = l.y() + r.y();
  if (!(height > 0)) return std::numeric_limits<double>::infinity();
  const double crossing = (l.x() * r.y() + r.x() * l.y()) / height;
  if (crossing < 0 || crossing > length) return std::numeric_limits<double>::infinity();
  return std::hypot(l.x() - r.x(), height);
}

std::vector<int> ComponentOf(const std::vector<std::vector<int>>& neighbors) {
  std::vector<int> component(neighbors.size(), -1);
  int count = 0;
  for (std::size_t seed = 0; seed < neighbors.size(); ++seed) {
    if (component[seed] >= 0) continue;
    std::vector<int> stack = {static_cast<int>(seed)};
    component[seed] = count;
    while (!stack.empty()) {
      const int v = stack.back();
      stack.pop_back();
      for (const int w : neighbors[v])
        if (component[w] < 0) {
          component[w] = count;
          stack.push_back(w);
        }
    }
    ++count;
  }
  return component;
}

PointsX3 SomeRows(const PointsX3& points, const std::vector<int>& rows) {
  PointsX3 some(std::ssize(rows), 3);
  for (std::size_t i = 0; i < rows.size(); ++i) some.row(i) = points.row(rows[i]);
  return some;
}

/// One arc from each further piece to the nearest vertex of the pieces that are joined already.
/// Pieces are joined in order of size.
std::vector<Arc> Bridges(const PointsX3& points, const std::vector<std::vector<int>>& neighbors) {
  const std::vector<int> component = ComponentOf(neighbors);
  const int count =
      component.empty() ? 0 : 1 + *std::max_element(component.begin(), component.end());
  std::vector<std::vector<int>> members(static_cast<std::size_t>(count));
  for (std::size_t v = 0; v < component.size(); ++v)
    members[component[v]].push_back(static_cast<int>(v));
  std::stable_sort(members.begin(), members.end(),
                   [](const auto& a, const auto& b) { return a.size() > b.size(); });
  std::vector<Arc> arcs;
  if (members.empty()) return arcs;
  std::vector<int> joined = members[0];
  for (std::size_t c = 1; c < members.size(); ++c) {
    const KdTree tree(SomeRows(points, joined));
    Arc best{-1, -1, std::numeric_limits<double>::infinity()};
    for (const int v : members[c]) {
      const KdTree::Neighbor near = tree.Nearest(points.row(v).transpose());
      const double d = std::sqrt(near.squared_distance);
      if (d < best.length) best = {v, joined[near.index], d};
    }
    arcs.push_back(best);
    joined.insert(joined.end(), members[c].begin(), members[c].end());
  }
  return arcs;
}

}  // namespace

GeodesicGraph::GeodesicGraph(const PointsX3& points, const FacesX3& faces, Ways ways)
    : neighbors_(static_cast<std::size_t>(points.rows())) {
  if (points.rows() == 0)
    throw InputError("register: distances along a surface need a mesh with vertices");
  std::vector<Arc> arcs;
  for (const SharedEdge& edge : ways == kEdgesOnly ? EdgesAlone(faces) : SharedEdges(faces)) {
    arcs.push_back({edge.a, edge.b, (points.row(edge.a) - points.row(edge.b)).norm()});
    neighbors_[edge.a].push_back(edge.b);
    neighbors_[edge.b].push_back(edge.a);
    if (edge.right < 0 || edge.left == edge.right) continue;
    const double length = UnfoldedLength(edge, points);
    if (std::isfinite(length)) arcs.push_back({edge.left, edge.right, length});
  }
  for (const Arc& arc : Bridges(points, neighbors_)) {
    arcs.push_back(arc);
    neighbors_[arc.from].push_back(arc.to);
    neighbors_[arc.to].push_back(arc.from);
  }
  offset_.assign(static_cast<std::size_t>(points.rows()) + 1, 0);
  for (const Arc& arc : arcs) {
    ++offset_[static_cast<std::size_t>(arc.from) + 1];
    ++offset_[static_cast<std::size_t>(arc.to) + 1];
  }
  std::partial_sum(offset_.begin(), offset_.end(), offset_.begin());
  ways_.resize(2 * arcs.size());
  std::vector<int> fill = offset_;
  double total = 0;
  for (const Arc& arc : arcs) {
    for (const auto& [from, to] : {std::pair(arc.from, arc.to), std::pair(arc.to, arc.from)})
      ways_[fill[from]++] = {arc.length, to};
    total += arc.length;
  }
  // A step is a quarter of the mean length, so no distance has more than four times as many steps
  // as there are arcs.
  steps_per_length_ = 4 * static_cast<double>(arcs.size()) / total;
  if (!std::isfinite(steps_per_length_)) steps_per_length_ = 0;
}

void GeodesicGraph::Spread(const std::vector<int>& seeds, Eigen::VectorXd& distance,
                           std::vector<int>* nearest) const {
  // Within a step a vertex may be visited again with a smaller distance. The result is bit for bit
  // that of a heap: the smallest sum along all paths. It takes a third of the time.
  StepQueue queue(steps_per_length_);
  for (const int seed : seeds) queue.Put(seed, distance[seed]);
  queue.Run([&](int v, double here) {
    if (here > distance[v]) return;
    for (int k = offset_[v]; k < offset_[static_cast<std::size_t>(v) + 1]; ++k) {
      const Way& way = ways_[k];
      const double through = here + way.length;
      if (!(through < distance[way.to])) continue;
      distance[way.to] = through;
      if (nearest) (*nearest)[way.to] = (*nearest)[v];
      queue.Put(way.to, through);
    }
  });
}

Eigen::VectorXd GeodesicGraph::From(const std::vector<int>& sources,
                                    std::vector<int>* nearest) const {
  Eigen::VectorXd distance =
      Eigen::VectorXd::Constant(size(), std::numeric_limits<double>::infinity());
  if (nearest) nearest->assign(static_cast<std::size_t>(size()), -1);
  for (std::size_t s = 0; s < sources.size(); ++s) {
    distance[sources[s]] = 0;
    if (nearest) (*nearest)[sources[s]] = static_cast<int>(s);
  }
  Spread(sources, distance, nearest);
  return distance;
}

Eigen::MatrixXd GeodesicGraph::Rows(const std::vector<int>& sources) const {
  Eigen::MatrixXd columns(size(), std::ssize(sources));
  ParallelFor(columns.cols(), [&](std::int64_t s) { columns.col(s) = From({sources[s]}); });
  return columns.transpose();
}

std::vector<int> GeodesicGraph::FarthestPoints(int count, std::vector<int> given) const {
  count = std::min(count, size());
  if (given.empty()) {
    // The vertex farthest from any given vertex is the end of a limb.
    Eigen::Index end = 0;
    From({0}).maxCoeff(&end);
    given.push_back(static_cast<int>(end));
  }
  Eigen::VectorXd distance = From(given);
  while (SizeOf(given) < count) {
    Eigen::Index farthest = 0;
    if (!(distance.maxCoeff(&farthest) > 0)) break;
    given.push_back(static_cast<int>(farthest));
    // Only distances of vertices that are nearer to the new point than to all others change, so the
    // search stops beyond these.
    distance[farthest] = 0;
    Spread({static_cast<int>(farthest)}, distance, nullptr);
  }
  return given;
}

std::vector<Peak> FindPeaks(const std::vector<std::vector<int>>& neighbors,
                            const Eigen::VectorXd& field) {
  const auto n = neighbors.size();
  std::vector<int> order(n), parent(n, -1), peak(n);
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return field[a] > field[b]; });
  const auto root = [&](int v) {
    while (parent[v] != v) {
      auto& up = parent[v];
      up = parent[up];
      v = up;
    }
    return v;
  };
  std::vector<Peak> peaks;
  for (const int v : order) {  // a peak ends where its region meets that of a higher one
    parent[v] = v;
    peak[v] = v;
    for (const int w : neighbors[v]) {
      if (parent[w] < 0) continue;
      int high = root(v), low = root(w);
      if (high == low) continue;
      if (field[peak[low]] > field[peak[high]]) std::swap(high, low);
      const int dying = peak[low];
      if (field[dying] > field[v]) peaks.push_back({dying, field[dying] - field[v]});
      parent[low] = high;
    }
  }
  for (std::size_t v = 0; v < n; ++v)
    if (parent[v] == static_cast<int>(v))
      peaks.push_back({peak[v], field[peak[v]] - field.minCoeff()});
  std::stable_sort(peaks.begin(), peaks.end(),
                   [](const Peak& a, const Peak& b) { return a.persistence > b.persistence; });
  return peaks;
}

}  // namespace keypose
