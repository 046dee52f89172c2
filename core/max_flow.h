// Least cuts of small graphs, for choosing labels.
#pragma once

#include <cstdint>
#include <vector>

namespace keypose {

/// A graph of nodes between a source and a sink; integer capacities, so the cut is exact and the
/// same everywhere.
///
/// Source: Dinic, Soviet Math. Doklady 1970 (shortest augmenting paths by layers).
class MinCut {
 public:
  explicit MinCut(int nodes);
  /// Adds to the capacities source -> node and node -> sink, both >= 0.
  void AddTerminals(int node, std::int64_t from_source, std::int64_t to_sink);
  /// Capacities a -> b and b -> a, both >= 0.
  void AddEdge(int a, int b, std::int64_t forward, std::int64_t backward);
  /// @return the least cut's capacity
  std::int64_t Solve();
  /// After Solve: whether the node is on the source's side. Nodes that could be on either are on
  /// the sink's.
  bool WithSource(int node) const { return layer_[node] >= 0; }

 private:
  struct Arc {
    int to, next;
    std::int64_t room;
  };
  void AddArc(int from, int to, std::int64_t room);
  bool Layers();
  std::int64_t Augment();

  int source_, sink_;
  std::vector<Arc> arcs_;  ///< arc i and i ^ 1 are each other's reverse
  std::vector<int> first_, layer_, current_, queue_, path_;
  std::vector<std::int64_t> from_source_, to_sink_;
};

}  // namespace keypose
