#include "cleanup/repair/handle_loops.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <queue>
#include <utility>

#include "core/surfaces/geometry.h"
#include "core/values/union_find.h"

namespace keypose::cleanup {
namespace {

constexpr int kReroots = 6;  // searches from a vertex of the shortest loop
constexpr double kInfinite = std::numeric_limits<double>::infinity();

struct Link {
  int a, b;
  double length;
  int faces[2];
};

// The graph of the mesh's edges, built once.
class Graph {
 public:
  explicit Graph(const Mesh& closed);
  /// The loops of all edges that are neither in the tree of paths from the roots nor in the dual
  /// tree, the shortest first. Each piece has one root; `root` is that of its own piece.
  std::vector<std::vector<int>> Loops(int root) const;
  double Length(const std::vector<int>& loop) const;

 private:
  void ShortestPaths(int root, std::vector<double>& far, std::vector<int>& link) const;
  std::vector<int> PathToRoot(int v, const std::vector<int>& link) const;

  const Mesh& mesh_;
  std::vector<Link> links_;
  std::vector<int> begin_, incident_;
};

Graph::Graph(const Mesh& closed) : mesh_(closed), begin_(closed.vertex_count() + 1, 0) {
  std::vector<std::array<int, 3>> sides;
  for (int f = 0; f < closed.face_count(); ++f)
    for (int k = 0; k < 3; ++k) {
      const auto [a, b] = std::minmax(closed.faces(f, k), closed.faces(f, (k + 1) % 3));
      sides.push_back({a, b, f});
    }
  std::sort(sides.begin(), sides.end());
  for (std::size_t i = 0; i + 1 < sides.size(); i += 2) {
    const auto& [a, b, f] = sides[i];
    links_.push_back(
        {a, b, (closed.points.row(a) - closed.points.row(b)).norm(), {f, sides[i + 1][2]}});
    ++begin_[a + 1];
    ++begin_[b + 1];
  }
  std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
  incident_.resize(2 * links_.size());
  std::vector<int> at(begin_.begin(), begin_.end() - 1);
  for (int i = 0; i < std::ssize(links_); ++i) {
    incident_[at[links_[i].a]++] = i;
    incident_[at[links_[i].b]++] = i;
  }
}

// Dijkstra. In pieces without `root` it starts at their first vertex.
void Graph::ShortestPaths(int root, std::vector<double>& far, std::vector<int>& link) const {
  far.assign(mesh_.vertex_count(), kInfinite);
  link.assign(mesh_.vertex_count(), -1);
  using Entry = std::pair<double, int>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  const auto spread = [&](int start) {
    if (far[start] < kInfinite) return;
    far[start] = 0;
    queue.emplace(0, start);
    while (!queue.empty()) {
      const auto [distance, v] = queue.top();
      queue.pop();
      if (distance > far[v]) continue;
      for (int i = begin_[v]; i < begin_[v + 1]; ++i) {
        const Link& l = links_[incident_[i]];
        const int w = l.a == v ? l.b : l.a;
        if (distance + l.length >= far[w]) continue;
        far[w] = distance + l.length;
        link[w] = incident_[i];
        queue.emplace(far[w], w);
      }
    }
  };
  spread(root);
  for (int v = 0; v < mesh_.vertex_count(); ++v) spread(v);
}

std::vector<int> Graph::PathToRoot(int v, const std::vector<int>& link) const {
  std::vector<int> path = {v};
  while (link[v] >= 0) {
    const Link& l = links_[link[v]];
    v = l.a == v ? l.b : l.a;
    path.push_back(v);
  }
  return path;
}

std::vector<std::vector<int>> Graph::Loops(int root) const {
  std::vector<double> far;
  std::vector<int> link;
  ShortestPaths(root, far, link);
  std::vector<char> in_tree(links_.size(), 0);
  for (const int l : link)
    if (l >= 0) in_tree[l] = 1;
  std::vector<std::pair<double, int>> rest;
  for (int i = 0; i < std::ssize(links_); ++i)
    if (!in_tree[i]) rest.emplace_back(far[links_[i].a] + far[links_[i].b] + links_[i].length, i);
  std::sort(rest.begin(), rest.end(), std::greater<>());
  // Faces are joined across the edges of the longest loops first. The edges that remain are those
  // of the handles' shortest loops.
  UnionFind joined(mesh_.face_count());
  std::vector<std::vector<int>> loops;
  for (const auto& [length, i] : rest) {
    if (joined.Join(links_[i].faces[0], links_[i].faces[1])) continue;
    std::vector<int> left = PathToRoot(links_[i].a, link), right = PathToRoot(links_[i].b, link);
    int shared = -1;
    while (!left.empty() && !right.empty() && left.back() == right.back()) {
      shared = left.back();
      left.pop_back();
      right.pop_back();
    }
    left.push_back(shared);
    left.insert(left.end(), right.rbegin(), right.rend());
    loops.push_back(left);
  }
  std::stable_sort(loops.begin(), loops.end(),
                   [&](const auto& a, const auto& b) { return Length(a) < Length(b); });
  return loops;
}

double Graph::Length(const std::vector<int>& loop) const { return LoopLength(mesh_, loop); }

}  // namespace

double LoopLength(const Mesh& mesh, const std::vector<int>& loop) {
  double sum = 0;
  for (std::size_t i = 0; i < loop.size(); ++i)
    sum += (mesh.points.row(loop[i]) - mesh.points.row(loop[(i + 1) % loop.size()])).norm();
  return sum;
}

int Genus(const Mesh& closed) {
  const ClosedReport report = CheckClosed(closed);
  return report.components - report.euler / 2;
}

std::vector<std::vector<int>> HandleLoops(const Mesh& closed) {
  const Graph graph(closed);
  std::vector<std::vector<int>> best = graph.Loops(0);
  std::vector<std::vector<int>> seen = best;
  for (int round = 0; round < kReroots && !best.empty(); ++round) {
    const double length = graph.Length(best[0]);
    best = graph.Loops(best[0][best[0].size() / 2]);
    seen.insert(seen.end(), best.begin(), best.end());
    if (!(graph.Length(best[0]) < length * (1 - 1e-12))) break;
  }
  std::stable_sort(seen.begin(), seen.end(),
                   [&](const auto& a, const auto& b) { return graph.Length(a) < graph.Length(b); });
  // Different roots give the same loop.
  const auto same = [&](const auto& a, const auto& b) {
    return std::abs(graph.Length(a) - graph.Length(b)) <= 1e-12 * graph.Length(b);
  };
  seen.erase(std::unique(seen.begin(), seen.end(), same), seen.end());
  return seen;
}

std::vector<std::vector<int>> LoopBasis(const Mesh& closed) {
  return Genus(closed) > 0 ? Graph(closed).Loops(0) : std::vector<std::vector<int>>();
}

}  // namespace keypose::cleanup
