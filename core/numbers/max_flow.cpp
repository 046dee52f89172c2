#include "core/numbers/max_flow.h"

#include <algorithm>
#include <boost/graph/boykov_kolmogorov_max_flow.hpp>
#include <boost/graph/compressed_sparse_row_graph.hpp>
#include <boost/property_map/property_map.hpp>
#include <numeric>
#include <utility>

#include "core/values/size_of.h"

namespace keypose {

namespace {

using Graph =
    boost::compressed_sparse_row_graph<boost::directedS, boost::no_property, boost::no_property,
                                       boost::no_property, std::uint32_t, std::uint32_t>;
using Edge = boost::graph_traits<Graph>::edge_descriptor;

/// Values that are accessed by the index of a node or an edge.
template <class Value, class Index>
auto MapOf(std::vector<Value>& values, const Index& index) {
  return boost::make_iterator_property_map(values.begin(), index);
}

}  // namespace

MinCut::MinCut(int nodes) : from_source_(nodes, 0), to_sink_(nodes, 0) {}

void MinCut::AddTerminals(int node, std::int64_t from_source, std::int64_t to_sink) {
  from_source_[node] += from_source;
  to_sink_[node] += to_sink;
}

void MinCut::AddEdge(int a, int b, std::int64_t forward, std::int64_t backward) {
  const auto from = static_cast<std::uint32_t>(a), to = static_cast<std::uint32_t>(b);
  arcs_.push_back({from, to, forward});
  arcs_.push_back({to, from, backward});
}

std::int64_t MinCut::Solve() {
  const int nodes = SizeOf(from_source_), source = nodes, sink = nodes + 1;
  std::int64_t flow = 0;
  for (int node = 0; node < nodes; ++node) {
    // Flow straight from source to sink through one node needs no search.
    const std::int64_t through = std::min(from_source_[node], to_sink_[node]);
    flow += through;
    if (from_source_[node] > through) AddEdge(source, node, from_source_[node] - through, 0);
    if (to_sink_[node] > through) AddEdge(node, sink, to_sink_[node] - through, 0);
  }

  std::vector<std::uint32_t> place(arcs_.size());  // of each arc in the order by `from`
  std::vector<std::uint32_t> next(nodes + 3, 0);
  for (const Arc& arc : arcs_) ++next[arc.from + 1];
  std::partial_sum(next.begin(), next.end(), next.begin());
  for (std::size_t i = 0; i < arcs_.size(); ++i) place[i] = next[arcs_[i].from]++;

  std::vector<std::pair<std::uint32_t, std::uint32_t>> ends(arcs_.size());
  std::vector<std::int64_t> capacity(arcs_.size()), room(arcs_.size());
  for (std::size_t i = 0; i < arcs_.size(); ++i) {
    ends[place[i]] = {arcs_[i].from, arcs_[i].to};
    capacity[place[i]] = arcs_[i].capacity;
  }
  const Graph graph(boost::edges_are_sorted, ends.begin(), ends.end(),
                    static_cast<std::uint32_t>(nodes + 2));
  const auto [first, last] = boost::edges(graph);
  const std::vector<Edge> edges(first, last);
  std::vector<Edge> reverse(arcs_.size());
  for (std::size_t i = 0; i < arcs_.size(); ++i) reverse[place[i]] = edges[place[i ^ 1]];

  const auto edge_index = boost::get(boost::edge_index, graph);
  const auto node_index = boost::get(boost::vertex_index, graph);
  std::vector<Edge> parent(nodes + 2);
  std::vector<boost::default_color_type> tree(nodes + 2, boost::gray_color);
  std::vector<long> distance(nodes + 2);
  flow += boost::boykov_kolmogorov_max_flow(
      graph, MapOf(capacity, edge_index), MapOf(room, edge_index), MapOf(reverse, edge_index),
      MapOf(parent, node_index), MapOf(tree, node_index), MapOf(distance, node_index), node_index,
      static_cast<std::uint32_t>(source), static_cast<std::uint32_t>(sink));

  with_source_.resize(nodes);
  for (int node = 0; node < nodes; ++node) with_source_[node] = tree[node] == boost::black_color;
  return flow;
}

}  // namespace keypose
