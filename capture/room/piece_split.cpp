#include "capture/room/piece_split.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <queue>
#include <utility>

#include "core/numbers/max_flow.h"
#include "core/values/size_of.h"

namespace keypose::capture {
namespace {

constexpr float kStep = 0.05F;         // of a step within one colour
constexpr float kColourScale = 30.0F;  // grey levels of a step that costs 1 more
constexpr float kMuchNearer = 0.4F;    // of the way to the other marks: such points are sure
constexpr float kLargest = 1000;       // capacity between points of one colour
constexpr float kLeaning = 300;        // of a point that only its place speaks for
constexpr float kLeast = 50;           // and of any colours: narrow places are cut

/// Differences of colour, relative to their scale, squared.
float Difference(const Eigen::Vector3f& a, const Eigen::Vector3f& b) {
  return (a - b).squaredNorm() / (3 * kColourScale * kColourScale);
}

/// Of a border between two points that lie beside each other.
std::int64_t CostBetween(const ColouredSurface& surface, std::size_t a, std::size_t b) {
  const float same = std::exp(-Difference(surface.colours[a], surface.colours[b]));
  return std::lround(kLeast + kLargest * same);
}

/// The cheapest way from each point to a mark.
std::vector<float> WaysTo(const ColouredSurface& surface, const std::vector<int>& marks) {
  std::vector<float> way(surface.colours.size(), std::numeric_limits<float>::infinity());
  using Entry = std::pair<float, int>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  for (const int i : marks) open.emplace(0.0F, i);
  while (!open.empty()) {
    const auto [here, i] = open.top();
    open.pop();
    const auto at = static_cast<std::size_t>(i);
    if (here >= way[at]) continue;
    way[at] = here;
    for (const int n : surface.neighbours[at]) {
      const auto next = static_cast<std::size_t>(n);
      const float there = here + kStep + Difference(surface.colours[at], surface.colours[next]);
      if (there < way[next]) open.emplace(there, n);
    }
  }
  return way;
}

}  // namespace

std::vector<char> OtherPart(const ColouredSurface& surface, const std::vector<int>& figure,
                            const std::vector<int>& other) {
  constexpr std::int64_t kSure = 1 << 30;
  const std::vector<float> to_figure = WaysTo(surface, figure), to_other = WaysTo(surface, other);
  MinCut cut(SizeOf(surface.colours));
  for (std::size_t i = 0; i < surface.colours.size(); ++i) {
    const float lean = surface.lean.empty() ? 0.0F : surface.lean[i];
    const bool is_figure =
                   to_figure[i] == 0 || (lean <= 0 && to_figure[i] < kMuchNearer * to_other[i]),
               is_other =
                   (lean >= 0 && to_other[i] < kMuchNearer * to_figure[i]) || to_other[i] == 0;
    const auto leans = [lean](float sign) {
      return static_cast<std::int64_t>(std::lround(kLeaning * std::max(0.0F, sign * lean)));
    };
    cut.AddTerminals(static_cast<int>(i), is_other ? kSure : leans(1),
                     is_figure && !is_other ? kSure : leans(-1));
    for (const int n : surface.neighbours[i]) {
      if (n <= static_cast<int>(i)) continue;
      const std::int64_t capacity = CostBetween(surface, i, static_cast<std::size_t>(n));
      cut.AddEdge(static_cast<int>(i), n, capacity, capacity);
    }
  }
  cut.Solve();
  std::vector<char> is_other;
  for (std::size_t i = 0; i < surface.colours.size(); ++i)
    is_other.push_back(cut.WithSource(static_cast<int>(i)));
  return is_other;
}

double BorderOf(const ColouredSurface& surface, const std::vector<char>& is_other) {
  double cost = 0, others = 0;
  for (std::size_t i = 0; i < is_other.size(); ++i) {
    others += is_other[i];
    for (const int n : surface.neighbours[i])
      if (is_other[i] && !is_other[static_cast<std::size_t>(n)])
        cost += static_cast<double>(CostBetween(surface, i, static_cast<std::size_t>(n)));
  }
  const double smaller = std::min(others, static_cast<double>(is_other.size()) - others);
  return smaller > 0 ? cost / std::sqrt(smaller) : std::numeric_limits<double>::infinity();
}

}  // namespace keypose::capture
