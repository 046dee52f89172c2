#include "core/max_flow.h"

#include <algorithm>
#include <limits>

namespace keypose {

MinCut::MinCut(int nodes)
    : source_(nodes),
      sink_(nodes + 1),
      first_(nodes + 2, -1),
      from_source_(nodes, 0),
      to_sink_(nodes, 0) {}

void MinCut::AddTerminals(int node, std::int64_t from_source, std::int64_t to_sink) {
  from_source_[node] += from_source;
  to_sink_[node] += to_sink;
}

void MinCut::AddArc(int from, int to, std::int64_t room) {
  arcs_.push_back({to, first_[from], room});
  first_[from] = static_cast<int>(arcs_.size()) - 1;
}

void MinCut::AddEdge(int a, int b, std::int64_t forward, std::int64_t backward) {
  AddArc(a, b, forward);
  AddArc(b, a, backward);
}

bool MinCut::Layers() {
  layer_.assign(first_.size(), -1);
  queue_.assign(1, source_);
  layer_[source_] = 0;
  for (std::size_t i = 0; i < queue_.size(); ++i)
    for (int arc = first_[queue_[i]]; arc >= 0; arc = arcs_[arc].next)
      if (arcs_[arc].room > 0 && layer_[arcs_[arc].to] < 0) {
        layer_[arcs_[arc].to] = layer_[queue_[i]] + 1;
        queue_.push_back(arcs_[arc].to);
      }
  return layer_[sink_] >= 0;
}

/// One path through the layers, by depth first search that never tries a dead arc twice; 0 when
/// there is none left.
std::int64_t MinCut::Augment() {
  path_.clear();
  int node = source_;
  while (node != sink_) {
    int& arc = current_[node];
    while (arc >= 0 && !(arcs_[arc].room > 0 && layer_[arcs_[arc].to] == layer_[node] + 1))
      arc = arcs_[arc].next;
    if (arc >= 0) {
      path_.push_back(arc);
      node = arcs_[arc].to;
      continue;
    }
    if (path_.empty()) return 0;
    const int back = path_.back();
    path_.pop_back();
    node = arcs_[back ^ 1].to;
    current_[node] = arcs_[back].next;
  }
  std::int64_t room = std::numeric_limits<std::int64_t>::max();
  for (const int arc : path_) room = std::min(room, arcs_[arc].room);
  for (const int arc : path_) {
    arcs_[arc].room -= room;
    arcs_[arc ^ 1].room += room;
  }
  return room;
}

std::int64_t MinCut::Solve() {
  std::int64_t flow = 0;
  for (int node = 0; node < source_; ++node) {
    // What passes straight through a node needs no search.
    const std::int64_t through = std::min(from_source_[node], to_sink_[node]);
    flow += through;
    if (from_source_[node] > through) AddEdge(source_, node, from_source_[node] - through, 0);
    if (to_sink_[node] > through) AddEdge(node, sink_, to_sink_[node] - through, 0);
  }
  while (Layers()) {
    current_ = first_;
    while (const std::int64_t room = Augment()) flow += room;
  }
  return flow;
}

}  // namespace keypose
