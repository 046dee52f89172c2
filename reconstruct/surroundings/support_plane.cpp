#include "reconstruct/surroundings/support_plane.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <random>
#include <vector>

#include "core/numbers/statistics.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose::reconstruct {
namespace {

using Eigen::Vector3d;

constexpr int kTries = 3000;
constexpr std::size_t kMostPoints = 4000;  // more are thinned evenly
constexpr double kNearness = 0.3;   // of the distance: points farther from the figure count less
constexpr double kOneSide = 0.95;   // least share of the cameras above the plane
constexpr double kNotBelow = 0.15;  // of the distance: people often aim at the mat before it

Vector3d AxisOf(const View& view) {
  return view.camera_from_world.rotation.conjugate() * Vector3d::UnitZ();
}

struct Near {
  Vector3d position;
  double weight;
};

struct Plane {
  Vector3d normal;
  double offset;
  double Above(const Vector3d& x) const { return normal.dot(x) - offset; }
};

/// The points within reach, thinned, with more weight near the middle.
std::vector<Near> PointsAround(const Scene& scene, const Vector3d& middle, double reach,
                               double distance) {
  std::vector<Near> all;
  for (const SparsePoint& point : scene.points) {
    const double away = (point.position - middle).norm();
    if (away < reach)
      all.push_back({point.position, std::exp(-std::pow(away / (kNearness * distance), 2))});
  }
  if (all.size() <= kMostPoints) return all;
  std::vector<Near> some;
  for (std::size_t k = 0; k < kMostPoints; ++k) some.push_back(all[k * all.size() / kMostPoints]);
  return some;
}

/// Least squares through the points within the thickness, with their weights.
Plane Refit(const std::vector<Near>& points, const Plane& plane, double thickness) {
  Vector3d mean = Vector3d::Zero();
  double sum = 0;
  for (const Near& p : points)
    if (std::abs(plane.Above(p.position)) < thickness) {
      mean += p.weight * p.position;
      sum += p.weight;
    }
  mean /= sum;
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const Near& p : points)
    if (std::abs(plane.Above(p.position)) < thickness)
      scatter += p.weight * (p.position - mean) * (p.position - mean).transpose();
  Vector3d normal = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter).eigenvectors().col(0);
  if (normal.dot(plane.normal) < 0) normal = -normal;
  return {normal, normal.dot(mean)};
}

/// Whether the plane is level where that can be told, the cameras are above it, and what they look
/// at is not below.
bool Supports(const Plane& plane, const std::vector<View>& views, const Vector3d& middle,
              double distance, const SupportPlaneOptions& options) {
  if (options.up && plane.normal.dot(*options.up) < std::cos(options.tilt)) return false;
  if (plane.Above(middle) < -kNotBelow * distance) return false;
  const auto above = std::count_if(
      views.begin(), views.end(), [&](const View& view) { return plane.Above(view.Center()) > 0; });
  return static_cast<double>(above) >= kOneSide * static_cast<double>(views.size());
}

double WeightWithin(const std::vector<Near>& points, const Plane& plane, double thickness) {
  double sum = 0;
  for (const Near& p : points)
    if (std::abs(plane.Above(p.position)) < thickness) sum += p.weight;
  return sum;
}

std::optional<Plane> BestPlane(const std::vector<Near>& points, const std::vector<View>& views,
                               const Vector3d& middle, double distance,
                               const SupportPlaneOptions& options) {
  const double thickness = options.thickness * distance;
  std::mt19937 random(1);
  const auto any = [&] { return random() % points.size(); };
  std::optional<Plane> best;
  double most = 0;
  for (int t = 0; t < kTries; ++t) {
    const std::array<Vector3d, 3> p{points[any()].position, points[any()].position,
                                    points[any()].position};
    Vector3d normal = (p[1] - p[0]).cross(p[2] - p[0]);
    if (normal.norm() < 1e-4 * distance * distance) continue;
    normal.normalize();
    if (normal.dot(views.front().Center() - p[0]) < 0) normal = -normal;
    const Plane plane{normal, normal.dot(p[0])};
    if (!Supports(plane, views, middle, distance, options)) continue;
    const double weight = WeightWithin(points, plane, thickness);
    if (weight <= most) continue;
    most = weight;
    best = plane;
  }
  return best;
}

}  // namespace

Vector3d LookedAt(const std::vector<View>& views) {
  if (views.size() < 2) throw InputError("two views or more are needed to tell what they look at");
  std::vector<double> weights(views.size(), 1);
  Vector3d middle = Vector3d::Zero();
  for (int round = 0; round < 10; ++round) {
    Eigen::Matrix3d a = Eigen::Matrix3d::Identity() * 1e-9;
    Vector3d b = Vector3d::Zero();
    for (std::size_t v = 0; v < views.size(); ++v) {
      const Vector3d axis = AxisOf(views[v]);
      const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - axis * axis.transpose();
      a += weights[v] * across;
      b += weights[v] * (across * views[v].Center());
    }
    middle = a.ldlt().solve(b);
    std::vector<double> misses(views.size());
    for (std::size_t v = 0; v < views.size(); ++v)
      misses[v] = AxisOf(views[v]).cross(middle - views[v].Center()).norm();
    const double usual = std::max(1e-12, UpperMedian(misses));
    for (std::size_t v = 0; v < views.size(); ++v)
      weights[v] = 1 / (1 + std::pow(misses[v] / (2 * usual), 2));
  }
  return middle;
}

std::optional<SupportPlane> FindSupportPlane(const Scene& scene,
                                             const SupportPlaneOptions& options) {
  const Vector3d middle = LookedAt(scene.views);
  std::vector<double> distances;
  for (const View& view : scene.views) distances.push_back((view.Center() - middle).norm());
  const double distance = UpperMedian(distances);
  const double thickness = options.thickness * distance;
  const std::vector<Near> points = PointsAround(scene, middle, options.reach * distance, distance);
  if (SizeOf(points) < options.fewest) return std::nullopt;
  std::optional<Plane> plane = BestPlane(points, scene.views, middle, distance, options);
  if (!plane) return std::nullopt;
  for (int round = 0; round < 3; ++round) plane = Refit(points, *plane, thickness);
  if (!Supports(*plane, scene.views, middle, distance, options)) return std::nullopt;
  const auto on = std::count_if(points.begin(), points.end(), [&](const Near& p) {
    return std::abs(plane->Above(p.position)) < thickness;
  });
  if (on < options.fewest ||
      static_cast<double>(on) < options.share * static_cast<double>(points.size()))
    return std::nullopt;
  SupportPlane support;
  support.normal = plane->normal;
  support.offset = plane->offset;
  support.foot = middle - plane->Above(middle) * plane->normal;
  support.distance = distance;
  support.points = static_cast<int>(on);
  return support;
}

}  // namespace keypose::reconstruct
