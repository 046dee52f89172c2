#include "cleanup/strategies/measure.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <vector>

#include "cleanup/repair/intersections.h"
#include "core/numbers/parallel.h"
#include "core/numbers/statistics.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/ray_scene.h"
#include "core/surfaces/surface_distance.h"
#include "core/values/errors.h"

namespace keypose::cleanup {
namespace {

constexpr int kSamples = 20000;
constexpr std::uint64_t kSeed = 5;

double MinAngleDeg(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  const auto angle = [](const Eigen::Vector3d& u, const Eigen::Vector3d& v) {
    return std::atan2(u.cross(v).norm(), u.dot(v));
  };
  return std::min({angle(b - a, c - a), angle(a - b, c - b), angle(a - c, b - c)}) * 180 / EIGEN_PI;
}

SurfaceDistance Distance(const Mesh& from, const Mesh& to) {
  const RayScene scene(to.points, to.faces);
  Eigen::VectorXd distances = SampledDistances(from, scene, kSamples, kSeed);
  SurfaceDistance out;
  for (const double d : distances) out.mean += d;
  out.mean /= static_cast<double>(distances.size());
  out.max = distances.maxCoeff();
  out.p99 = QuantileAbove(std::move(distances), 0.99);
  return out;
}

}  // namespace

void Measure(const Mesh& mesh, double diagonal, CleanupResult& result) {
  const ClosedReport report = CheckClosed(mesh);
  // scaled to 1, because the predicates' filters only work in a certain range
  Mesh scaled = mesh;
  scaled.points /= diagonal;
  IntersectingFaces(scaled, &result.self_intersections);
  if (!report.closed() || result.self_intersections > 0) {
    throw QualityError("cleanup: the finished mesh fails its test (" +
                       std::to_string(report.bad_edges) + " bad edges, " +
                       std::to_string(report.bad_fans) + " bad vertices, " +
                       std::to_string(report.zero_area_faces) + " faces without area, " +
                       std::to_string(result.self_intersections) +
                       " intersecting pairs); try another value of --faces");
  }
  result.components = report.components;
  result.genus = report.components - report.euler / 2;
  result.volume = report.volume;
  result.area = SurfaceArea(mesh.points, mesh.faces);
  result.min_angle_deg = 60;
  double sum = 0;
  for (int f = 0; f < mesh.face_count(); ++f) {
    const double angle =
        MinAngleDeg(mesh.points.row(mesh.faces(f, 0)), mesh.points.row(mesh.faces(f, 1)),
                    mesh.points.row(mesh.faces(f, 2)));
    result.min_angle_deg = std::min(result.min_angle_deg, angle);
    sum += angle;
  }
  result.mean_min_angle_deg = sum / mesh.face_count();
}

void MeasureDistances(const Mesh& mesh, const Mesh& input, const Mesh& kept,
                      CleanupResult& result) {
  result.to_input = Distance(mesh, input);
  result.from_input = Distance(kept, mesh);
}

double LeastAngleDeg(const Mesh& mesh) {
  double least = 60;
  for (int f = 0; f < mesh.face_count(); ++f)
    least = std::min(
        least, MinAngleDeg(mesh.points.row(mesh.faces(f, 0)), mesh.points.row(mesh.faces(f, 1)),
                           mesh.points.row(mesh.faces(f, 2))));
  return least;
}

double ShareFartherThan(const Mesh& from, const Mesh& to, double distance) {
  constexpr int kFew = 4000;
  const SurfaceSamples samples = SampleSurface(from.points, from.faces, kFew, kSeed);
  const RayScene scene(to.points, to.faces);
  int far = 0;
  for (int i = 0; i < kFew; ++i)
    far += scene.ClosestPoint(samples.points.row(i).transpose(), distance).face < 0;
  return static_cast<double>(far) / kFew;
}

ColorsX3 ColorsFrom(const Mesh& colored, const PointsX3& points) {
  const RayScene scene(colored.points, colored.faces);
  ColorsX3 colors(points.rows(), 3);
  ParallelFor(
      points.rows(),
      [&](std::int64_t v) {
        const RayScene::Foot foot = scene.ClosestPoint(points.row(v).transpose());
        Eigen::RowVector3d color = Eigen::RowVector3d::Zero();
        for (int k = 0; k < 3; ++k)
          color +=
              foot.barycentric[k] * colored.colors.row(colored.faces(foot.face, k)).cast<double>();
        colors.row(v) = color.array().round().max(0).min(255).cast<std::uint8_t>();
      },
      256);
  return colors;
}

}  // namespace keypose::cleanup
