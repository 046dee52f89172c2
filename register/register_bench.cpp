// Registration of the paper's size (3,490 triangles, 267.6 s in MATLAB), and by the default method
// up to a million faces.
#include <benchmark/benchmark.h>
#include <sys/resource.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <string>
#include <vector>

#include "core/surfaces/geometry.h"
#include "core/surfaces/shapes.h"
#include "core/values/size_of.h"
#include "register/auto/auto_registration.h"
#include "register/nricp/nricp.h"
#include "register/quality/registration_quality.h"

namespace {

using namespace keypose;

void Register(benchmark::State& state, bool exact) {
  // 42 x 42 tube with 3,528 faces plus caps, bent by 40 degrees. The target has another mesh.
  Mesh source = MakeCylinder(0.3, 2, 42, 41), target = MakeCylinder(0.3, 2, 37, 47);
  const auto bend = [](const PointsX3& p) {
    PointsX3 b = p;
    for (Eigen::Index i = 0; i < p.rows(); ++i) {
      const double radius = 2 / 0.7, a = p(i, 2) / radius, r = radius - p(i, 0);
      b.row(i) << radius - r * std::cos(a), p(i, 1), r * std::sin(a);
    }
    return b;
  };
  const PointsX3 truth = bend(source.points);
  target.points = bend(target.points);
  std::vector<LandmarkGoal> goals;
  for (int l = 0; l < 13; ++l) {
    LandmarkGoal goal;
    const int vertex = l * source.vertex_count() / 13;
    goal.name = std::to_string(vertex);
    goal.source.vertices.setConstant(vertex);
    goal.target = truth.row(vertex);
    goals.push_back(goal);
  }
  registration::NricpOptions options;
  options.exact_solves = exact;
  registration::NricpResult result;
  for (auto _ : state) result = registration::RegisterNricp(source, target, goals, {}, options);
  const auto q = registration::MeasureRegistration(source, result.points, target);
  const double diagonal = BoundingDiagonal(target.points);
  state.counters["faces"] = source.face_count();
  state.counters["iterations"] = result.iterations;
  state.counters["factorisations"] = result.factorisations;
  state.counters["pcg_steps"] = static_cast<double>(result.pcg_steps);
  state.counters["search_s"] = result.seconds_search;
  state.counters["solve_s"] = result.seconds_solve;
  state.counters["error_over_diag"] = (result.points - truth).rowwise().norm().mean() / diagonal;
  state.counters["surface_rms_over_diag"] = q.surface_rms;
  state.counters["flipped"] = q.flipped;
}

BENCHMARK_CAPTURE(Register, LaggedFactor, false)
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime();
BENCHMARK_CAPTURE(Register, FactorAtEverySolve, true)
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime();

constexpr double kRadius = 0.3, kLength = 2;

/// A closed rod along z with about 38 side^2 nearly equilateral faces and no poles: a box of
/// side x side x m cells whose square cross-section is mapped to a disc. `turn` rotates the
/// tessellation, not the shape.
Mesh MakeRod(int side, double turn) {
  const int along = static_cast<int>(std::lround(kLength / (2 * M_PI * kRadius) * 4 * side));
  const std::array<int, 3> size = {side, side, along};
  std::map<std::array<int, 3>, int> index;
  std::vector<Eigen::Vector3d> points;
  std::vector<Eigen::Vector3i> faces;
  const auto vertex = [&](const std::array<int, 3>& at) {
    const auto [entry, added] = index.try_emplace(at, SizeOf(points));
    if (added) {
      const double x = 2.0 * at[0] / side - 1, y = 2.0 * at[1] / side - 1;
      const Eigen::Vector3d p(kRadius * x * std::sqrt(1 - y * y / 2),
                              kRadius * y * std::sqrt(1 - x * x / 2), kLength * at[2] / along);
      points.push_back(Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()) * p);
    }
    return entry->second;
  };
  for (int axis = 0; axis < 3; ++axis)
    for (int end = 0; end < 2; ++end)
      for (int u = 0; u < size[(axis + 1) % 3]; ++u)
        for (int v = 0; v < size[(axis + 2) % 3]; ++v) {
          int q[4];
          for (int k = 0; k < 4; ++k) {
            std::array<int, 3> at{};
            at[axis] = end * size[axis];
            at[(axis + 1) % 3] = u + (k == 1 || k == 2);
            at[(axis + 2) % 3] = v + (k >= 2);
            q[k] = vertex(at);
          }
          if (end == 0) std::swap(q[1], q[3]);
          faces.emplace_back(q[0], q[1], q[2]);
          faces.emplace_back(q[0], q[2], q[3]);
        }
  Mesh mesh;
  mesh.points.resize(std::ssize(points), 3);
  for (std::size_t k = 0; k < points.size(); ++k) mesh.points.row(k) = points[k].transpose();
  mesh.faces.resize(std::ssize(faces), 3);
  for (std::size_t k = 0; k < faces.size(); ++k) mesh.faces.row(k) = faces[k].transpose();
  return mesh;
}

PointsX3 BentBy(double angle, const PointsX3& p) {
  PointsX3 b = p;
  for (Eigen::Index i = 0; i < p.rows(); ++i) {
    const double radius = kLength / angle, a = p(i, 2) / radius, r = radius - p(i, 0);
    b.row(i) << radius - r * std::cos(a), p(i, 1), r * std::sin(a);
  }
  return b;
}

/// Thirteen landmarks on a spiral around the rod.
std::vector<LandmarkGoal> Spiral(const PointsX3& points, const PointsX3& truth) {
  std::vector<LandmarkGoal> goals;
  for (int l = 0; l < 13; ++l) {
    const Eigen::RowVector3d place(kRadius * std::cos(2.4 * l), kRadius * std::sin(2.4 * l),
                                   kLength * l / 12);
    Eigen::Index vertex = 0;
    (points.rowwise() - place).rowwise().squaredNorm().minCoeff(&vertex);
    LandmarkGoal goal;
    goal.name = std::to_string(l);
    goal.source.vertices.setConstant(static_cast<int>(vertex));
    goal.target = truth.row(vertex);
    goals.push_back(goal);
  }
  return goals;
}

/// The default method on a rod bent by 90 degrees. The target has another mesh. Errors are measured
/// against the known position of every vertex.
void RegisterAuto(benchmark::State& state) {
  const int side = std::max(
      3, static_cast<int>(std::lround(std::sqrt(static_cast<double>(state.range(0)) / 38))));
  const Mesh source = MakeRod(side, 0);
  Mesh target = MakeRod(static_cast<int>(std::lround(1.1 * side)) + 1, 0.37);
  target.points = BentBy(M_PI / 2, target.points);
  const PointsX3 truth = BentBy(M_PI / 2, source.points);
  const std::vector<LandmarkGoal> goals = Spiral(source.points, truth);
  registration::AutoResult result;
  for (auto _ : state) result = registration::RegisterAuto(source, target, goals, {}, {});
  state.SetComplexityN(source.face_count());
  const PointsX3 normals = FaceNormals(result.points, source.faces),
                 true_normals = FaceNormals(truth, source.faces);
  const Eigen::VectorXd errors =
      (result.points - truth).rowwise().norm() / BoundingDiagonal(target.points);
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  state.counters["faces"] = source.face_count();
  state.counters["levels"] = result.levels;
  state.counters["softened"] = result.softened;
  state.counters["error_over_diag"] = errors.mean();
  state.counters["largest_error_over_diag"] = errors.maxCoeff();
  state.counters["flipped"] =
      static_cast<double>((normals.cwiseProduct(true_normals).rowwise().sum().array() < 0).count());
  state.counters["peak_gib"] =
      static_cast<double>(usage.ru_maxrss) / (1 << 20);  // peak of the process so far
}

BENCHMARK(RegisterAuto)
    ->Arg(1000)
    ->Arg(3500)
    ->Arg(10000)
    ->Arg(33000)
    ->Arg(100000)
    ->Arg(330000)
    ->Arg(1000000)
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime()
    ->Complexity();

}  // namespace
