#include "reconstruct/bundle/track_selection.h"

#include <algorithm>
#include <array>
#include <map>
#include <tuple>

#include "core/numbers/statistics.h"
#include "core/values/size_of.h"
#include "core/values/tuned.h"

namespace keypose::reconstruct {

namespace {

// No record of the data. Sensitivity: docs/results/sensitivity.md.
struct TrackSelectionTuning {
  // along the object's longest side, over the middle nine tenths of its points
  KEYPOSE_TUNED(double, kCells, 24);
};

}  // namespace

PointSet KeepPoints(const Scene& scene, const std::vector<Observation>& observations,
                    const std::vector<char>& keep) {
  PointSet kept;
  kept.scene.views = scene.views;
  std::vector<int> index(scene.points.size(), -1);
  for (std::size_t p = 0; p < scene.points.size(); ++p) {
    if (!keep[p]) continue;
    index[p] = SizeOf(kept.scene.points);
    kept.scene.points.push_back(scene.points[p]);
  }
  for (const Observation& o : observations)
    if (const int p = index[o.point]; p >= 0) kept.observations.push_back({o.view, p, o.pixel});
  return kept;
}

PointSet SpreadPoints(const Scene& scene, const std::vector<Observation>& observations, int count) {
  if (SizeOf(scene.points) <= count) return {scene, observations};
  Eigen::Vector3d low, high;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> values;
    for (const SparsePoint& point : scene.points) values.push_back(point.position(axis));
    std::tie(low(axis), high(axis)) = TrimmedRange(std::move(values), 0.05);
  }
  const double cell = std::max((high - low).maxCoeff() / TrackSelectionTuning::kCells, 1e-12);
  // Within a cell, points with few views come last; distant outliers share the cells at the border.
  std::map<std::array<int, 3>, std::vector<int>> cells;
  for (std::size_t p = 0; p < scene.points.size(); ++p) {
    std::array<int, 3> at{};
    for (int axis = 0; axis < 3; ++axis)
      at[axis] = static_cast<int>(std::clamp((scene.points[p].position(axis) - low(axis)) / cell,
                                             -4.0, TrackSelectionTuning::kCells + 4.0));
    cells[at].push_back(static_cast<int>(p));
  }
  std::vector<std::pair<std::size_t, int>> by_turn;
  for (auto& [at, points] : cells) {
    std::sort(points.begin(), points.end(), [&](int a, int b) {
      const std::size_t views_a = scene.points[a].views.size(),
                        views_b = scene.points[b].views.size();
      return views_a != views_b ? views_a > views_b : a < b;
    });
    for (std::size_t k = 0; k < points.size(); ++k) by_turn.emplace_back(k, points[k]);
  }
  std::sort(by_turn.begin(), by_turn.end());
  std::vector<char> keep(scene.points.size(), 0);
  for (int k = 0; k < count; ++k) keep[by_turn[k].second] = 1;
  return KeepPoints(scene, observations, keep);
}

}  // namespace keypose::reconstruct
