#include "views/hull/frontier_points.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>

#include "core/numbers/parallel.h"

namespace keypose {
namespace {

constexpr double kLeastWeight = 0.4;

// The interval of the ray that all masks allow, if it is the only one.
std::optional<VisualHull::Interval> OnlyPiece(const VisualHull& hull,
                                              const Silhouettes& silhouettes,
                                              const Eigen::Vector3d& from,
                                              const Eigen::Vector3d& ray,
                                              const FrontierPointOptions& options) {
  const auto bounds = hull.March(from, ray);
  if (!bounds) return std::nullopt;
  const double step = 0.5 * hull.cell / ray.norm(),
               longest = options.longest_length * hull.cell * hull.size.maxCoeff() / ray.norm();
  auto allowed = [&](double t) { return silhouettes.Within(from + t * ray, options.tolerance_px); };
  std::optional<VisualHull::Interval> piece;
  for (double t = bounds->front; t <= bounds->back; t += step) {
    if (!allowed(t)) continue;
    if (!piece) piece = {t, t};
    if (t - piece->back > 1.5 * step || t - piece->front > longest)
      return std::nullopt;  // a second interval, or a long one
    piece->back = t;
  }
  if (!piece) return piece;
  double before = piece->front - step, after = piece->back + step;
  for (int k = 0; k < 3; ++k) {
    const double front = 0.5 * (before + piece->front), back = 0.5 * (piece->back + after);
    (allowed(front) ? piece->front : before) = front;
    (allowed(back) ? piece->back : after) = back;
  }
  return piece;
}

std::vector<FrontierPoint> FrontierPointsOf(const VisualHull& hull, const Silhouettes& silhouettes,
                                            const PreparedView& view, int index,
                                            const FrontierPointOptions& options) {
  const MaskField& field = silhouettes.field(index);
  const Eigen::Matrix3d world_from_camera =
      view.camera_from_world.rotation.conjugate().toRotationMatrix();
  const Eigen::Vector3d center = view.Center();
  const double longest = hull.cell * hull.size.maxCoeff();
  std::vector<FrontierPoint> frontier;
  for (int y = 3; y < field.height - 3; ++y)
    for (int x = 3 + (y & 1); x < field.width - 3; x += 2) {
      if (std::abs(field.At(x, y) + 0.5f) > 0.1f) continue;  // the last pixels inside
      Eigen::Vector2d out(field.At(x + 2, y) - field.At(x - 2, y),
                          field.At(x, y + 2) - field.At(x, y - 2));
      if (out.norm() < 2) continue;  // a thin structure or a notch
      out.normalize();
      const Eigen::Vector3d ray =
          world_from_camera * view.camera().Ray(x + 0.5 * out.x(), y + 0.5 * out.y());
      const auto piece = OnlyPiece(hull, silhouettes, center, ray, options);
      if (!piece) continue;
      const double length = (piece->back - piece->front) * ray.norm() / longest;
      if (length > options.longest_length) continue;
      FrontierPoint touch;
      touch.view = index;
      touch.point = center + 0.5 * (piece->front + piece->back) * ray;
      touch.normal = silhouettes.OutlineNormal(index, touch.point);
      if (touch.normal.isZero()) continue;
      const double excess = std::max(0.0, length - options.sure_length) /
                            std::max(1e-9, options.longest_length - options.sure_length);
      touch.weight = 1 - (1 - kLeastWeight) * excess;
      touch.footprint = silhouettes.See(index, touch.point).footprint;
      frontier.push_back(touch);
    }
  return frontier;
}

}  // namespace

std::vector<FrontierPoint> FindFrontierPoints(const VisualHull& hull,
                                              const Silhouettes& silhouettes,
                                              const std::vector<PreparedView>& views,
                                              const FrontierPointOptions& options) {
  std::vector<std::vector<FrontierPoint>> frontier(views.size());
  ParallelFor(std::ssize(views), [&](std::int64_t i) {
    frontier[i] = FrontierPointsOf(hull, silhouettes, views[i], static_cast<int>(i), options);
  });
  std::vector<FrontierPoint> all;
  for (const std::vector<FrontierPoint>& of_view : frontier)
    all.insert(all.end(), of_view.begin(), of_view.end());
  return all;
}

}  // namespace keypose
