#include "cleanup/strategies/changed_faces.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <optional>
#include <vector>

#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/ray_scene.h"
#include "core/surfaces/surface_distance.h"

namespace keypose::cleanup {
namespace {

constexpr int kDamageSamples = 20000;
constexpr std::uint64_t kDamageSeed = 5;

using Corners = std::array<std::array<double, 3>, 3>;

Corners CornersOf(const Mesh& mesh, int f) {
  Corners corners;
  for (int k = 0; k < 3; ++k)
    for (int c = 0; c < 3; ++c) corners[k][c] = mesh.points(mesh.faces(f, k), c);
  std::sort(corners.begin(), corners.end());
  return corners;
}

std::vector<Corners> SortedFaces(const Mesh& mesh) {
  std::vector<Corners> faces;
  for (int f = 0; f < mesh.face_count(); ++f) faces.push_back(CornersOf(mesh, f));
  std::sort(faces.begin(), faces.end());
  return faces;
}

// The points that are farther than `reach` from the damage.
PointsX3 Away(const PointsX3& points, const RayScene& damage, double reach) {
  std::vector<char> damaged(points.rows());
  const auto look = [&](std::int64_t i) {
    damaged[i] = damage.ClosestPoint(points.row(i).transpose(), reach).face >= 0;
  };
  ParallelFor(points.rows(), look, 256);
  PointsX3 away(std::count(damaged.begin(), damaged.end(), 0), 3);
  for (Eigen::Index i = 0, kept = 0; i < points.rows(); ++i)
    if (!damaged[i]) away.row(kept++) = points.row(i);
  return away;
}

// Distances of the samples of `from` from `to`, without samples near the damage.
SurfaceDistance DistanceAway(const Mesh& from, const Mesh& to,
                             const std::optional<RayScene>& damage, double reach, double* share) {
  const SurfaceSamples samples =
      SampleSurface(from.points, from.faces, kDamageSamples, kDamageSeed);
  const PointsX3 away = damage ? Away(samples.points, *damage, reach) : samples.points;
  Eigen::VectorXd distances = DistancesTo(RayScene(to.points, to.faces), away);
  std::sort(distances.begin(), distances.end());
  *share = static_cast<double>(distances.size()) / static_cast<double>(samples.points.rows());
  SurfaceDistance out;
  if (distances.size() == 0) return out;
  for (const double d : distances) out.mean += d;
  out.mean /= static_cast<double>(distances.size());
  out.p99 = distances[distances.size() * 99 / 100];
  out.max = distances[distances.size() - 1];
  return out;
}

}  // namespace

Mesh ChangedFaces(const Mesh& before, const Mesh& after) {
  const std::vector<Corners> a = SortedFaces(before), b = SortedFaces(after);
  std::vector<Corners> changed;
  std::set_symmetric_difference(a.begin(), a.end(), b.begin(), b.end(),
                                std::back_inserter(changed));
  Mesh mesh;
  const Eigen::Index count = std::ssize(changed);
  mesh.points.resize(3 * count, 3);
  mesh.faces.resize(count, 3);
  for (Eigen::Index f = 0; f < count; ++f)
    for (int k = 0; k < 3; ++k) {
      for (int c = 0; c < 3; ++c) mesh.points(3 * f + k, c) = changed[f][k][c];
      mesh.faces(f, k) = static_cast<int>(3 * f + k);
    }
  return mesh;
}

void MeasureUndamaged(const Mesh& mesh, const Mesh& kept, const Mesh& changed, double reach,
                      CleanupResult& result) {
  std::optional<RayScene> damage;
  if (changed.face_count() > 0) damage.emplace(changed.points, changed.faces);
  double share_of_result = 0;
  result.undamaged_to_input = DistanceAway(mesh, kept, damage, reach, &share_of_result);
  result.undamaged_from_input = DistanceAway(kept, mesh, damage, reach, &result.undamaged_share);
}

}  // namespace keypose::cleanup
