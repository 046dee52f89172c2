#include "synth/scores/score.h"

#include <algorithm>
#include <iterator>
#include <numeric>
#include <string>
#include <unordered_map>
#include <utility>

#include "core/numbers/parallel.h"
#include "core/numbers/statistics.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/mesh_checks.h"
#include "core/surfaces/ray_scene.h"
#include "core/surfaces/surface_distance.h"
#include "core/values/errors.h"
#include "core/values/same_faces.h"
#include "core/values/size_of.h"

namespace keypose::synth {
namespace {

constexpr int kSamples = 40000;

std::vector<RayScene::Foot> Feet(const RayScene& scene, const PointsX3& points) {
  std::vector<RayScene::Foot> feet(points.rows());
  ParallelFor(
      points.rows(), [&](std::int64_t i) { feet[i] = scene.ClosestPoint(points.row(i)); }, 64);
  return feet;
}

struct Spread {
  double mean = 0, p95 = 0, max = 0;
};

Spread SpreadOf(std::vector<double> values) {
  if (values.empty()) return {};
  std::sort(values.begin(), values.end());
  const double sum = std::accumulate(values.begin(), values.end(), 0.0);
  return {sum / static_cast<double>(values.size()), values[(values.size() - 1) * 95 / 100],
          values.back()};
}

Spread SurfaceDistances(const Mesh& from, const Mesh& to, double unit) {
  const RayScene scene(to.points, to.faces);
  const Eigen::VectorXd distances = SampledDistances(from, scene, kSamples, 1) / unit;
  return SpreadOf({distances.begin(), distances.end()});
}

}  // namespace

CameraScore ScoreCameras(const Scene& truth, const Scene& model, const Eigen::Vector3d& center) {
  std::unordered_map<std::string, const View*> by_name;
  for (const View& view : model.views) by_name[view.name] = &view;
  std::vector<Eigen::Vector3d> true_centers, model_centers;
  double distance = 0;
  for (const View& view : truth.views) {
    distance += (view.Center() - center).norm() / static_cast<double>(truth.views.size());
    const auto found = by_name.find(view.name);
    if (found == by_name.end()) continue;
    true_centers.push_back(view.Center());
    model_centers.push_back(found->second->Center());
  }
  const Eigen::Index count = std::ssize(true_centers);
  if (count < 3)
    throw InputError(
        "synth: only " + std::to_string(count) +
        " of the true cameras are in the model; 3 are needed, so check that both are of one pose");
  PointsX3 a(count, 3), b(count, 3);
  for (Eigen::Index i = 0; i < count; ++i) {
    a.row(i) = model_centers[i].transpose();
    b.row(i) = true_centers[i].transpose();
  }
  CameraScore score;
  score.truth_from_model = FitSimilarity(a, b);
  score.placed = static_cast<int>(count);
  score.total = SizeOf(truth.views);
  const Eigen::VectorXd errors = (Transformed(score.truth_from_model, a) - b).rowwise().norm();
  score.mean_m = errors.mean();
  score.max_m = errors.maxCoeff();
  score.mean_over_distance = score.mean_m / distance;
  score.max_over_distance = score.max_m / distance;
  return score;
}

SurfaceScore ScoreSurface(const Mesh& truth, const Mesh& mesh) {
  const double diagonal = BoundingDiagonal(truth.points);
  const Spread to = SurfaceDistances(mesh, truth, diagonal),
               from = SurfaceDistances(truth, mesh, diagonal);
  return {to.mean, to.p95, to.max, from.mean, from.p95, from.max};
}

Similarity3 RefineAlignment(const Mesh& truth, const Mesh& mesh, const Similarity3& truth_from_mesh,
                            int rounds) {
  const RayScene scene(truth.points, truth.faces);
  const PointsX3 samples = SampleSurface(mesh.points, mesh.faces, 6000, 2).points;
  Similarity3 best = truth_from_mesh;
  for (int round = 0; round < rounds; ++round) {
    const std::vector<RayScene::Foot> feet = Feet(scene, Transformed(best, samples));
    std::vector<double> squares;
    PointsX3 goals(samples.rows(), 3);
    for (Eigen::Index i = 0; i < samples.rows(); ++i) {
      goals.row(i) = feet[i].point.transpose();
      squares.push_back(feet[i].squared_distance);
    }
    const double limit = QuantileAbove(std::move(squares), 0.9);
    Eigen::VectorXd weights(samples.rows());
    for (Eigen::Index i = 0; i < samples.rows(); ++i)
      weights[i] = feet[i].squared_distance <= limit ? 1 : 0;
    best = FitSimilarity(samples, goals, weights);
  }
  return best;
}

CorrespondenceScore ScoreCorrespondence(const Mesh& truth_a, const Mesh& truth_b,
                                        const Mesh& template_a, const PointsX3& registered_b) {
  if (truth_a.points.rows() != truth_b.points.rows() || !SameFaces(truth_a.faces, truth_b.faces))
    throw InputError(
        "synth: the true surfaces are not two poses of one world; render them together");
  RequireOnePerVertex(registered_b.rows(), template_a.points.rows(),
                      "synth: the registered mesh has", "vertices", "the template",
                      "; compare it with the template that it was registered from");
  const RayScene scene(truth_a.points, truth_a.faces);
  const std::vector<RayScene::Foot> feet = Feet(scene, template_a.points);
  const double diagonal = BoundingDiagonal(truth_b.points);
  PointsX3 places(registered_b.rows(), 3);
  std::vector<double> errors;
  for (Eigen::Index i = 0; i < registered_b.rows(); ++i) {
    const auto corners = truth_b.faces.row(feet[i].face);
    places.row(i) = feet[i].barycentric[0] * truth_b.points.row(corners[0]) +
                    feet[i].barycentric[1] * truth_b.points.row(corners[1]) +
                    feet[i].barycentric[2] * truth_b.points.row(corners[2]);
    errors.push_back((registered_b.row(i) - places.row(i)).norm() / diagonal);
  }
  const PointsX3 normals = FaceNormals(registered_b, template_a.faces),
                 true_normals = FaceNormals(places, template_a.faces);
  const auto opposed = (normals.cwiseProduct(true_normals).rowwise().sum().array() < 0).count();
  const Spread spread = SpreadOf(std::move(errors));
  return {spread.mean, spread.p95, spread.max, static_cast<int>(opposed)};
}

}  // namespace keypose::synth
