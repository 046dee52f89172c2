#include "interpolate/surface/loose_parts.h"

#include <algorithm>
#include <cmath>

#include "core/values/tuned.h"

namespace keypose::interpolation {

namespace {

// No record of the data; sensitivity: docs/results/sensitivity.md.
struct LoosePartsTuning {
  KEYPOSE_TUNED(double, kSmall, 0.2);  // of the body's area: larger parts move on their own
  KEYPOSE_TUNED(double, kNear, 1.5);   // of the part's radius: from its centroid to the body
  KEYPOSE_TUNED(int, kPatch, 24);      // vertices of the body that a part follows
};

Eigen::Vector3d MeanOf(const PointsX3& points, const std::vector<int>& vertices) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int i : vertices) sum += points.row(i).transpose();
  return sum / static_cast<double>(vertices.size());
}

/// The body's vertices nearest to the part's centroid; none if the part does not lie on the body.
std::vector<int> NearestPatch(const PointsX3& points, const std::vector<int>& part,
                              const std::vector<int>& body) {
  const Eigen::Vector3d centre = MeanOf(points, part);
  const auto distance = [&](int i) { return (points.row(i).transpose() - centre).squaredNorm(); };
  double radius = 0;
  for (int i : part) radius = std::max(radius, distance(i));
  std::vector<int> patch = body;
  const std::size_t count = std::min<std::size_t>(LoosePartsTuning::kPatch, patch.size());
  std::partial_sort(patch.begin(), patch.begin() + static_cast<std::ptrdiff_t>(count), patch.end(),
                    [&](int a, int b) {
                      return std::make_pair(distance(a), a) < std::make_pair(distance(b), b);
                    });
  patch.resize(count);
  if (patch.empty() ||
      distance(patch[0]) > LoosePartsTuning::kNear * LoosePartsTuning::kNear * radius)
    patch.clear();
  return patch;
}

}  // namespace

LooseParts::LooseParts(const PoissonSystem& system, const PointsX3& v, const PointsX3& u,
                       const SegmentMaps& maps)
    : body_turn_(maps.body_turn) {
  if (system.part_count() < 2) return;
  std::vector<double> area(system.part_count(), 0);
  for (Eigen::Index f = 0; f < system.faces().rows(); ++f)
    area[system.parts()[system.faces()(f, 0)]] += system.face_areas()[f];
  const auto body = static_cast<int>(std::max_element(area.begin(), area.end()) - area.begin());
  std::vector<std::vector<int>> members(system.part_count());
  for (int i = 0; i < system.vertex_count(); ++i) members[system.parts()[i]].push_back(i);
  const Eigen::Matrix3d back = ExpOf(body_turn_).transpose();
  for (const int source : system.row_sources()) {
    const int part = -1 - source;
    if (source >= 0 || part == body || area[part] >= LoosePartsTuning::kSmall * area[body])
      continue;  // only parts that are placed by their centroid
    std::vector<int> patch = NearestPatch(v, members[part], members[body]);
    const std::vector<int> patch_u = NearestPatch(u, members[part], members[body]);
    if (patch.empty() || patch_u.empty()) continue;
    patch.insert(patch.end(), patch_u.begin(), patch_u.end());
    std::sort(patch.begin(), patch.end());
    patch.erase(std::unique(patch.begin(), patch.end()), patch.end());
    Rider rider{members[part], patch, Eigen::Vector3d::Zero(), {}, {}};
    if (maps.vertex_turns.rows() > 0) rider.turn = MeanOf(maps.vertex_turns, patch);
    rider.start = MeanOf(v, rider.own) - MeanOf(v, patch);
    rider.end = QuaternionOf(-rider.turn) * (back * (MeanOf(u, rider.own) - MeanOf(u, patch)));
    riders_.push_back(std::move(rider));
  }
}

void LooseParts::Place(double t, PointsX3& frame) const {
  const Eigen::Matrix3d body = ExpOf(t * body_turn_);
  for (const Rider& rider : riders_) {
    const Eigen::Vector3d offset =
        body * (QuaternionOf(t * rider.turn) * ((1 - t) * rider.start + t * rider.end));
    const Eigen::Vector3d shift = MeanOf(frame, rider.patch) + offset - MeanOf(frame, rider.own);
    for (int i : rider.own) frame.row(i) += shift.transpose();
  }
}

}  // namespace keypose::interpolation
