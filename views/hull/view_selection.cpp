#include "views/hull/view_selection.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "core/numbers/parallel.h"
#include "core/values/size_of.h"
#include "core/values/tuned.h"

namespace keypose {
namespace {

constexpr int kFewPoints = 100;
constexpr int kHullPoints = 500;

// Angles between the rays of two views to a point. Least, best and most are OpenMVS's defaults, the
// spreads starting values; there is no record that others were tried. Sensitivity:
// docs/results/sensitivity.md.
struct SourceAngleTuning {
  KEYPOSE_TUNED(double, kLeast_deg, 3);   // below, a pair has no weight
  KEYPOSE_TUNED(double, kBest_deg, 12);   // full weight
  KEYPOSE_TUNED(double, kMost_deg, 65);   // above, a pair has no weight
  KEYPOSE_TUNED(double, kBelow_deg, 5);   // spread of the weights below the best angle
  KEYPOSE_TUNED(double, kAbove_deg, 15);  // spread of the weights above it
};

struct Sight {
  Eigen::Vector3d point;
  std::vector<int> others;  // views that see it too
};

double AngleWeight(double degrees) {
  using Tuning = SourceAngleTuning;
  if (degrees < Tuning::kLeast_deg || degrees > Tuning::kMost_deg) return 0;
  const double sigma = degrees < Tuning::kBest_deg ? Tuning::kBelow_deg : Tuning::kAbove_deg;
  return std::exp(-(degrees - Tuning::kBest_deg) * (degrees - Tuning::kBest_deg) /
                  (2 * sigma * sigma));
}

bool InMaskAt(const PreparedView& view, const Eigen::Vector3d& point) {
  const Eigen::Vector3d x = view.camera_from_world * point;
  if (x.z() <= 0) return false;
  const Eigen::Vector2d p = view.camera().Project(x);
  if (!(p.x() > -0.5 && p.y() > -0.5 && p.x() < view.camera().width - 0.5 &&
        p.y() < view.camera().height - 0.5))
    return false;
  return InMask(
      *view.levels[0].grey.at(static_cast<int>(p.x() + 0.5), static_cast<int>(p.y() + 0.5)));
}

// Whether the point is on the front of the hull as seen from the view.
bool InFront(const PreparedView& view, const DepthBounds& bounds, const Eigen::Vector3d& point) {
  if (!InMaskAt(view, point)) return false;
  const Eigen::Vector3d x = view.camera_from_world * point;
  const Eigen::Vector2d p = view.camera(bounds.shift).Project(x);
  const int px = std::clamp(static_cast<int>(std::lround(p.x())), 0, bounds.nearest.width - 1);
  const int py = std::clamp(static_cast<int>(std::lround(p.y())), 0, bounds.nearest.height - 1);
  const double nearest = *bounds.nearest.at(px, py), farthest = *bounds.farthest.at(px, py);
  return nearest > 0 && 1 / x.z() > nearest - 0.35 * (nearest - farthest);
}

std::vector<std::vector<Sight>> SparseSights(const std::vector<PreparedView>& views,
                                             const Scene& scene) {
  std::vector<int> dense_of(scene.views.size(), -1);
  for (std::size_t i = 0; i < views.size(); ++i)
    if (views[i].scene_index >= 0 && views[i].scene_index < std::ssize(dense_of))
      dense_of[views[i].scene_index] = static_cast<int>(i);
  std::vector<std::vector<Sight>> sights(views.size());
  for (const SparsePoint& point : scene.points) {
    std::vector<int> seen;
    for (const int v : point.views)
      if (v >= 0 && v < std::ssize(dense_of) && dense_of[v] >= 0 &&
          InMaskAt(views[dense_of[v]], point.position))
        seen.push_back(dense_of[v]);
    for (const int v : seen) sights[v].push_back({point.position, seen});
  }
  return sights;
}

std::vector<Sight> HullSights(const std::vector<PreparedView>& views,
                              const std::vector<DepthBounds>& bounds, int view) {
  const DepthBounds& b = bounds[view];
  std::vector<std::size_t> pixels;
  for (std::size_t i = 0; i < b.nearest.data.size(); ++i)
    if (b.nearest.data[i] > 0) pixels.push_back(i);
  const Eigen::Vector3d center = views[view].Center();
  std::vector<Sight> sights;
  const std::size_t step = std::max<std::size_t>(1, pixels.size() / kHullPoints);
  for (std::size_t i = 0; i < pixels.size(); i += step) {
    const int x = static_cast<int>(pixels[i] % b.nearest.width),
              y = static_cast<int>(pixels[i] / b.nearest.width);
    const Eigen::Vector3d ray = views[view].camera(b.shift).Ray(x, y) / *b.nearest.at(x, y);
    Sight sight{center + views[view].camera_from_world.rotation.conjugate() * ray, {}};
    for (std::size_t s = 0; s < views.size(); ++s)
      if (static_cast<int>(s) != view && InFront(views[s], bounds[s], sight.point))
        sight.others.push_back(static_cast<int>(s));
    sights.push_back(std::move(sight));
  }
  return sights;
}

std::vector<int> Best(const std::vector<PreparedView>& views, int view,
                      const std::vector<Sight>& sights, int count) {
  std::vector<double> score(views.size(), 0);
  std::vector<Eigen::Vector3d> centers;
  for (const PreparedView& v : views) centers.push_back(v.Center());
  for (const Sight& sight : sights)
    for (const int s : sight.others) {
      if (s == view) continue;
      const Eigen::Vector3d a = centers[view] - sight.point, b = centers[s] - sight.point;
      const double degrees =
          std::acos(std::clamp(a.dot(b) / (a.norm() * b.norm()), -1.0, 1.0)) * 180 / M_PI;
      const double ratio = (views[s].camera().fx / b.norm()) / (views[view].camera().fx / a.norm());
      score[s] += AngleWeight(degrees) * std::min(1.0, ratio * ratio);
    }
  std::vector<int> order;
  for (std::size_t s = 0; s < views.size(); ++s)
    if (score[s] > 0) order.push_back(static_cast<int>(s));
  std::stable_sort(order.begin(), order.end(), [&](int i, int j) { return score[i] > score[j]; });
  if (SizeOf(order) > count) order.resize(count);
  return order;
}

}  // namespace

std::vector<std::vector<int>> SelectSourceViews(const std::vector<PreparedView>& views,
                                                const std::vector<DepthBounds>& bounds,
                                                const Scene& scene, int count) {
  const std::vector<std::vector<Sight>> sparse = SparseSights(views, scene);
  std::vector<std::vector<int>> sources(views.size());
  ParallelFor(std::ssize(views), [&](std::int64_t i) {
    const int view = static_cast<int>(i);
    if (SizeOf(sparse[view]) >= kFewPoints) sources[view] = Best(views, view, sparse[view], count);
    if (SizeOf(sources[view]) >= count) return;
    for (const int s : Best(views, view, HullSights(views, bounds, view), count))
      if (SizeOf(sources[view]) < count &&
          std::find(sources[view].begin(), sources[view].end(), s) == sources[view].end())
        sources[view].push_back(s);
  });
  return sources;
}

}  // namespace keypose
