#include "deform/solvers/sparse_pattern.h"

#include <algorithm>

#include "core/surfaces/geometry.h"
#include "core/values/union_find.h"

namespace keypose {

int SparsePattern::EdgeIndex(int i, int j) const {
  const auto at = std::lower_bound(edges.begin(), edges.end(), std::make_pair(i, j));
  return at != edges.end() && *at == std::make_pair(i, j) ? static_cast<int>(at - edges.begin())
                                                          : -1;
}

int SparsePattern::Slot(int i, int r, int j, int c) const {
  if (i == j) return r >= c ? vertex_slot[i][c] + (r - c) : vertex_slot[i][r] + (c - r);
  if (i < j) {
    std::swap(i, j);
    std::swap(r, c);
  }
  const int e = EdgeIndex(j, i);
  return edge_slot[e][c] + (edge_full[e] ? r : 0);
}

SparsePattern MakeSparsePattern(int vertex_count, const FacesX3& faces,
                                const std::vector<std::pair<int, int>>& mixed) {
  SparsePattern p;
  p.vertex_count = vertex_count;
  p.edges = UndirectedEdges(faces);
  std::erase_if(p.edges, [](const auto& e) { return e.first == e.second; });
  std::vector<std::pair<int, int>> full = mixed;
  for (auto& e : full)
    if (e.first > e.second) std::swap(e.first, e.second);
  std::sort(full.begin(), full.end());
  p.edges.insert(p.edges.end(), full.begin(), full.end());
  std::sort(p.edges.begin(), p.edges.end());
  p.edges.erase(std::unique(p.edges.begin(), p.edges.end()), p.edges.end());
  p.edge_full.resize(p.edges.size());
  for (std::size_t e = 0; e < p.edges.size(); ++e)
    p.edge_full[e] = std::binary_search(full.begin(), full.end(), p.edges[e]);

  p.vertex_slot.resize(vertex_count);
  p.edge_slot.resize(p.edges.size());
  p.columns.reserve(4 * vertex_count + 1);
  p.rows.reserve(10 * static_cast<std::size_t>(vertex_count) + 4 * p.edges.size());
  std::size_t begin = 0;
  for (int i = 0; i < vertex_count; ++i) {
    std::size_t end = begin;
    while (end < p.edges.size() && p.edges[end].first == i) ++end;
    for (int k = 0; k < 4; ++k) {
      p.columns.push_back(p.nonzeros());
      p.vertex_slot[i][k] = p.nonzeros();
      for (int r = k; r < 4; ++r) p.rows.push_back(4 * i + r);
      for (std::size_t e = begin; e < end; ++e) {
        p.edge_slot[e][k] = p.nonzeros();
        const int j = p.edges[e].second;
        if (!p.edge_full[e]) p.rows.push_back(4 * j + k);
        if (p.edge_full[e])
          for (int r = 0; r < 4; ++r) p.rows.push_back(4 * j + r);
      }
    }
    begin = end;
  }
  p.columns.push_back(p.nonzeros());
  return p;
}

std::vector<int> Components(int vertex_count, const std::vector<std::pair<int, int>>& edges,
                            int& count) {
  UnionFind joined(vertex_count);
  for (const auto& [i, j] : edges) joined.Join(i, j);
  count = 0;
  std::vector<int> component(vertex_count, -1);
  for (int i = 0; i < vertex_count; ++i) {
    const int root = joined.Find(i);
    component[i] = root == i ? count++ : component[root];  // a root is the lowest vertex of its
                                                           // component, so it gets its number first
  }
  return component;
}

}  // namespace keypose
