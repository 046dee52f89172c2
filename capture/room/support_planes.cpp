#include "capture/room/support_planes.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <random>

#include "core/numbers/statistics.h"
#include "core/values/size_of.h"

namespace keypose::capture {
namespace {

using Eigen::Vector3d;

constexpr int kTries = 400;
constexpr double kLevel = 0.9;            // cosine: the surface of a plane, and the plane
constexpr double kOneSide = 0.9;          // of the cameras are above it
constexpr double kFewestAtOneLevel = 50;  // voxels

bool IsBelow(const Support& plane, const std::vector<View>& views, const Vector3d& middle,
             double slack) {
  if (plane.Above(middle) < -slack) return false;
  const auto above = std::count_if(
      views.begin(), views.end(), [&](const View& view) { return plane.Above(view.Center()) > 0; });
  return static_cast<double>(above) >= kOneSide * static_cast<double>(views.size());
}

bool OnPlane(const ThinSurface& surface, std::size_t i, const Support& plane, double thickness) {
  return std::abs(plane.Above(surface.points[i])) < thickness &&
         surface.normals[i].dot(plane.up) > kLevel;
}

int CountOn(const ThinSurface& surface, const Support& plane, double thickness) {
  int count = 0;
  for (std::size_t i = 0; i < surface.points.size(); ++i)
    count += OnPlane(surface, i, plane, thickness);
  return count;
}

Support Refitted(const ThinSurface& surface, const Support& plane, double thickness) {
  Vector3d mean = Vector3d::Zero();
  int count = 0;
  for (std::size_t i = 0; i < surface.points.size(); ++i)
    if (OnPlane(surface, i, plane, thickness)) {
      mean += surface.points[i];
      ++count;
    }
  mean /= std::max(1, count);
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < surface.points.size(); ++i)
    if (OnPlane(surface, i, plane, thickness))
      scatter += (surface.points[i] - mean) * (surface.points[i] - mean).transpose();
  Vector3d up = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter).eigenvectors().col(0);
  if (up.dot(plane.up) < 0) up = -up;
  return {up, up.dot(mean)};
}

}  // namespace

ThinSurface SurfaceOf(const VoxelGrid& grid) {
  ThinSurface surface;
  for (const Voxel& voxel : grid.voxels()) {
    if (!voxel.several || voxel.outward.norm() < 1e-6F) continue;
    surface.points.push_back(voxel.Point());
    surface.normals.push_back(voxel.outward.cast<double>().normalized());
  }
  return surface;
}

bool IsWall(const Support& plane, const std::vector<View>& views, const Vector3d& middle,
            const SupportOptions& options) {
  std::vector<double> rises;
  Vector3d mean = Vector3d::Zero();
  for (const View& view : views) {
    rises.push_back(plane.up.dot((view.Center() - middle).normalized()));
    mean += view.camera_from_world.rotation * plane.up / static_cast<double>(views.size());
  }
  return UpperMedian(std::move(rises)) > options.steep && mean.head<2>().norm() < options.upright;
}

std::optional<Support> LargestPlane(const ThinSurface& surface, const std::vector<View>& views,
                                    const Vector3d& middle, double distance,
                                    const SupportOptions& options) {
  std::mt19937 random(1);
  const double thickness = options.thickness * distance;
  std::optional<Support> best;
  int most = 0;
  for (int t = 0; t < kTries; ++t) {
    const std::size_t i = random() % surface.points.size(), j = random() % surface.points.size(),
                      k = random() % surface.points.size();
    Vector3d up =
        (surface.points[j] - surface.points[i]).cross(surface.points[k] - surface.points[i]);
    if (up.norm() < 1e-3 * distance * distance) continue;
    up.normalize();
    if (up.dot(views.front().Center() - surface.points[i]) < 0) up = -up;
    const Support plane{up, up.dot(surface.points[i])};
    if (!IsBelow(plane, views, middle, 0.05 * distance)) continue;
    const int count = CountOn(surface, plane, thickness);
    if (count <= most) continue;
    most = count;
    best = plane;
  }
  if (!best) return std::nullopt;
  for (int round = 0; round < 3; ++round) best = Refitted(surface, *best, thickness);
  if (CountOn(surface, *best, thickness) < options.share * SizeOf(surface.points))
    return std::nullopt;
  return best;
}

std::vector<Support> PlanesAbove(const ThinSurface& surface, const Support& lowest,
                                 double thickness) {
  std::vector<double> level;
  for (std::size_t i = 0; i < surface.points.size(); ++i) {
    const double above = lowest.Above(surface.points[i]);
    if (above < -thickness || surface.normals[i].dot(lowest.up) < kLevel) continue;
    const auto bin = static_cast<std::size_t>((above + thickness) / thickness);
    if (bin >= level.size()) level.resize(bin + 1, 0);
    level[bin] += 1;
  }
  std::vector<Support> planes;
  for (std::size_t bin = level.size(); bin-- > 4;) {
    const auto at = [&](std::size_t b) { return b < level.size() ? level[b] : 0.0; };
    const double here = at(bin) + std::max(at(bin - 1), at(bin + 1));
    if (at(bin) < std::max(at(bin - 1), at(bin + 1)) || here < kFewestAtOneLevel) continue;
    Support plane = lowest;
    plane.height += (static_cast<double>(bin) - 0.5) * thickness;
    planes.push_back(Refitted(surface, plane, thickness));
  }
  planes.push_back(lowest);
  return planes;
}

}  // namespace keypose::capture
