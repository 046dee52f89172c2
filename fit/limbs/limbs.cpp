#include "fit/limbs/limbs.h"

#include <algorithm>

#include "core/surfaces/geometry.h"
#include "core/values/size_of.h"
#include "core/values/tuned.h"
#include "deform/levels/geodesics.h"

namespace keypose::fit {
namespace {

// Chosen on the clay creature's seeds 2 and 4 (synth).
struct LimbTuning {
  KEYPOSE_TUNED(double, kShortest, 0.08);  // of a limb, over the diagonal
  KEYPOSE_TUNED(double, kWider, 2);        // a ring beyond the neck over the neck
  KEYPOSE_TUNED(double, kLargest, 0.1);    // of a limb, share of the surface
};
constexpr int kSamples = 40;  // from which mean distances are taken

/// The vertices around a peak, in falling order of the field, down to `least` or to the area.
std::vector<int> Above(const std::vector<std::vector<int>>& neighbors, const Eigen::VectorXd& field,
                       const Eigen::VectorXd& areas, int peak, double least, double most_area) {
  std::vector<int> found;
  std::vector<char> seen(field.size(), 0);
  const auto lower = [&](int a, int b) { return field[a] < field[b]; };
  std::vector<int> heap{peak};
  seen[peak] = 1;
  double area = 0;
  while (!heap.empty()) {
    std::pop_heap(heap.begin(), heap.end(), lower);
    const int v = heap.back();
    heap.pop_back();
    area += areas[v];
    if (field[v] <= least || area > most_area) break;
    found.push_back(v);
    for (const int n : neighbors[v]) {
      if (seen[n]) continue;
      seen[n] = 1;
      heap.push_back(n);
      std::push_heap(heap.begin(), heap.end(), lower);
    }
  }
  return found;
}

/// Ends the limb at its neck, beyond which it becomes wide: an ear's part of the surface would
/// otherwise have some of the head.
void CutAtNeck(const Eigen::VectorXd& areas, double shortest, Limb& limb) {
  constexpr int kRingsInShortest = 8;
  const double step = shortest / kRingsInShortest;
  limb.length = limb.vertices.empty() ? 0 : limb.along.maxCoeff();
  std::vector<double> rings(2 + static_cast<std::size_t>(limb.length / step), 0.0);
  for (int i = 0; i < SizeOf(limb.vertices); ++i)
    rings[static_cast<std::size_t>(limb.along[i] / step)] += areas[limb.vertices[i]];
  const auto width = [&](int r) { return rings[r - 1] + 2 * rings[r] + rings[r + 1]; };
  for (int r = kRingsInShortest, neck = r; r + 1 < SizeOf(rings); ++r) {
    if (width(r) == 0) continue;  // faces are longer than rings
    if (width(r) < width(neck) || width(neck) == 0) neck = r;
    if (width(r) < LimbTuning::kWider * width(neck)) continue;
    limb.length = neck * step;
    break;
  }
  Limb cut;
  std::vector<double> along;
  for (int i = 0; i < SizeOf(limb.vertices); ++i) {
    if (limb.along[i] > limb.length) continue;
    cut.vertices.push_back(limb.vertices[i]);
    along.push_back(limb.along[i]);
  }
  cut.along = Eigen::Map<const Eigen::VectorXd>(along.data(), SizeOf(along));
  cut.length = along.empty() ? 0 : cut.along.maxCoeff();
  limb = std::move(cut);
}

}  // namespace

std::vector<Limb> FindLimbs(const PointsX3& points, const FacesX3& faces) {
  const GeodesicGraph graph(points, faces);
  const std::vector<int> samples = graph.FarthestPoints(std::min(kSamples, graph.size()));
  const Eigen::VectorXd field = graph.Rows(samples).colwise().mean();
  const Eigen::VectorXd areas = VertexAreas(points, faces);
  const double shortest = LimbTuning::kShortest * BoundingDiagonal(points);
  std::vector<Limb> limbs;
  for (const Peak& peak : FindPeaks(graph.neighbors(), field)) {
    if (peak.persistence < shortest) break;
    Limb limb;
    limb.vertices =
        Above(graph.neighbors(), field, areas, peak.vertex, field[peak.vertex] - peak.persistence,
              LimbTuning::kLargest * areas.sum());
    std::sort(limb.vertices.begin(), limb.vertices.end());
    const Eigen::VectorXd away = graph.From({peak.vertex});
    limb.along.resize(SizeOf(limb.vertices));
    for (int i = 0; i < SizeOf(limb.vertices); ++i) limb.along[i] = away[limb.vertices[i]];
    CutAtNeck(areas, shortest, limb);
    if (limb.length >= shortest) limbs.push_back(std::move(limb));
  }
  std::stable_sort(limbs.begin(), limbs.end(),
                   [](const Limb& a, const Limb& b) { return a.length > b.length; });
  return limbs;
}

}  // namespace keypose::fit
