#include "capture/room/room_evidence.h"

#include <cmath>
#include <cstddef>

#include "core/numbers/statistics.h"

namespace keypose::capture {
namespace {

double MedianDistance(const std::vector<View>& views) {
  std::vector<double> distances;
  for (const View& view : views) distances.push_back(view.Center().norm());
  return UpperMedian(std::move(distances));
}

bool InMask(const View& view, const Image8& mask, const Eigen::Vector3d& x) {
  const Eigen::Vector2d p = view.Project(x);
  const int px = static_cast<int>(std::floor(p.x())), py = static_cast<int>(std::floor(p.y()));
  return px >= 0 && py >= 0 && px < mask.width && py<mask.height&& * mask.at(px, py)> 127;
}

/// Whether most of the views that see the point have it in their masks.
bool InMostMasks(const Scene& scene, const std::vector<Image8>& masks, const SparsePoint& point) {
  std::size_t in = 0;
  for (const int v : point.views) {
    const auto view = static_cast<std::size_t>(v);
    in += InMask(scene.views[view], masks[view], point.position);
  }
  return 2 * in > point.views.size();
}

double Share(double part, double all) { return all > 0 ? part / all : 0; }

}  // namespace

RoomEvidence LookAround(const Scene& scene, const std::vector<Image8>& masks,
                        const RoomOptions& options) {
  RoomEvidence evidence;
  if (scene.points.empty() || scene.views.empty()) return evidence;
  const double distance = MedianDistance(scene.views);
  double inside = 0, inside_on_floor = 0, near = 0, near_on_floor = 0;
  for (const SparsePoint& point : scene.points) {
    const bool on_floor = std::abs(point.position.z()) < options.thickness * distance;
    const bool in_masks = InMostMasks(scene, masks, point);
    const bool is_near = point.position.norm() < options.reach * distance;
    inside += in_masks;
    inside_on_floor += in_masks && on_floor;
    near += is_near;
    near_on_floor += is_near && on_floor;
  }
  const auto all = static_cast<double>(scene.points.size());
  evidence.around = Share(all - inside, all);
  evidence.floor =
      near_on_floor >= options.fewest && Share(near_on_floor, near) >= options.floor_share;
  evidence.on_floor = Share(inside_on_floor, inside);
  // Masks that hold the whole mat have all points inside: the mat tells.
  evidence.floor_in_masks = evidence.floor && evidence.on_floor >= options.on_floor;
  evidence.in_room = evidence.around >= options.around;
  return evidence;
}

}  // namespace keypose::capture
