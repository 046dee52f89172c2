#include "synth/scores/dense_score.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "core/numbers/kd_tree.h"
#include "core/numbers/parallel.h"
#include "core/numbers/statistics.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/ray_scene.h"
#include "core/surfaces/surface_distance.h"
#include "core/values/errors.h"

namespace keypose::synth {
namespace {

using Eigen::Vector3d;

constexpr int kTruthSamples = 40000;
constexpr int kSeenBy = 3;

/// Points on the true surface, and whether enough cameras see them.
struct Places {
  PointsX3 points;
  std::vector<char> seen;
};

Places PlacesOn(const Mesh& truth, const std::vector<View>& views) {
  const SurfaceSamples samples = SampleSurface(truth.points, truth.faces, kTruthSamples, 3);
  const PointsX3 normals = FaceNormals(truth.points, truth.faces);
  const RayScene rays(truth.points, truth.faces);
  const double lift = 1e-5 * BoundingDiagonal(truth.points);
  Places places{samples.points, std::vector<char>(samples.points.rows(), 0)};
  const auto look = [&](std::int64_t i) {
    const Vector3d normal = normals.row(samples.faces[i]),
                   x = Vector3d(places.points.row(i)) + lift * normal;
    int count = 0;
    for (const View& view : views) {
      const Vector3d to_camera = view.Center() - x;
      count += normal.dot(to_camera.normalized()) > 0.1 && !rays.Occluded(x, to_camera, 0, 1);
    }
    places.seen[i] = count >= kSeenBy;
  };
  ParallelFor(places.points.rows(), look, 64);
  return places;
}

std::vector<double> Distances(const Mesh& to, const PointsX3& from) {
  const Eigen::VectorXd distances = DistancesTo(RayScene(to.points, to.faces), from);
  return {distances.begin(), distances.end()};
}

}  // namespace

double PixelFootprint(const std::vector<View>& views, const Vector3d& place) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const View& view : views)
    nearest = std::min(nearest, (view.Center() - place).norm() / view.camera.fx);
  return nearest;
}

PointsScore ScorePoints(const Mesh& truth, const std::vector<View>& views, const PointsX3& points,
                        double reach_m) {
  if (points.rows() == 0)
    throw InputError("synth: the cloud has no points; was anything reconstructed?");
  PointsScore score;
  score.points = static_cast<int>(points.rows());
  std::vector<double> distances = Distances(truth, points);
  for (Eigen::Index i = 0; i < points.rows(); ++i)
    distances[i] /= PixelFootprint(views, points.row(i));
  const auto near =
      std::count_if(distances.begin(), distances.end(), [](double d) { return d <= 1; });
  score.within_one_footprint = static_cast<double>(near) / static_cast<double>(distances.size());
  score.median = QuantileFloor(distances, 0.5);
  score.p90 = QuantileFloor(distances, 0.9);
  score.p99 = QuantileFloor(distances, 0.99);
  const Places places = PlacesOn(truth, views);
  const KdTree tree(points);
  std::vector<char> reached(places.seen.size());
  ParallelFor(
      places.points.rows(),
      [&](std::int64_t i) {
        reached[i] = tree.Nearest(places.points.row(i)).squared_distance <= reach_m * reach_m;
      },
      64);
  double seen = 0, both = 0, all = 0;
  for (std::size_t i = 0; i < reached.size(); ++i) {
    seen += places.seen[i];
    all += reached[i];
    both += places.seen[i] && reached[i];
  }
  score.completeness = all / static_cast<double>(reached.size());
  score.completeness_seen = seen > 0 ? both / seen : 0;
  return score;
}

DetailScore ScoreDetail(const Mesh& truth, const PointsX3& smooth, const Mesh& mesh) {
  if (smooth.rows() != truth.points.rows())
    throw InputError("synth: the smooth surface and the true one have different vertex counts");
  const PointsX3 normals = VertexNormals(smooth, truth.faces);
  const Eigen::VectorXd heights =
      ((truth.points - smooth).array() * normals.array()).rowwise().sum();
  const double full = heights.size() ? heights.cwiseAbs().maxCoeff() : 0;
  DetailScore score;
  if (full <= 0) return score;
  const RayScene scene(mesh.points, mesh.faces);
  std::vector<double> found(heights.size(), std::numeric_limits<double>::quiet_NaN());
  const double reach = 8 * full;
  const auto cast = [&](std::int64_t i) {
    if (std::abs(heights[i]) < full / 3) return;
    const Vector3d n = normals.row(i), start = Vector3d(smooth.row(i)) + reach * n;
    const RayScene::Hit hit = scene.Cast(start, -n, 0, 2 * reach);
    if (hit.face >= 0) found[i] = reach - hit.distance;
  };
  ParallelFor(heights.size(), cast, 64);
  double n = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0;
  for (Eigen::Index i = 0; i < heights.size(); ++i)
    if (std::isfinite(found[i])) {
      n += 1;
      x += heights[i];
      y += found[i];
      xx += heights[i] * heights[i];
      xy += heights[i] * found[i];
      yy += found[i] * found[i];
    }
  if (n < 2) return score;
  const double cxx = xx - x * x / n, cxy = xy - x * y / n, cyy = yy - y * y / n;
  score.places = static_cast<int>(n);
  score.gain = cxy / cxx;
  score.correlation = cyy > 0 ? cxy / std::sqrt(cxx * cyy) : 0;
  return score;
}

HullComparison CompareWithHull(const Mesh& truth, const std::vector<View>& views, const Mesh& mesh,
                               const Mesh& hull) {
  const Places places = PlacesOn(truth, views);
  const std::vector<double> to_mesh = Distances(mesh, places.points),
                            to_hull = Distances(hull, places.points);
  HullComparison comparison;
  std::vector<double> excess;
  double worse = 0;
  for (std::size_t i = 0; i < to_mesh.size(); ++i) {
    if (!places.seen[i]) continue;
    comparison.mean_m += to_mesh[i];
    comparison.hull_mean_m += to_hull[i];
    excess.push_back((to_mesh[i] - to_hull[i]) / PixelFootprint(views, places.points.row(i)));
    worse += excess.back() > 1;
  }
  if (excess.empty()) return comparison;
  const double count = static_cast<double>(excess.size());
  comparison.mean_m /= count;
  comparison.hull_mean_m /= count;
  comparison.worse_share = worse / count;
  comparison.worst_excess_footprints = QuantileFloor(std::move(excess), 0.999);
  return comparison;
}

}  // namespace keypose::synth
