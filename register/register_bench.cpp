// Registration at the paper's size (3,490 triangles there, 267.6 s in MATLAB).
#include <benchmark/benchmark.h>

#include <cmath>
#include <string>

#include "core/geometry.h"
#include "core/testing_shapes.h"
#include "register/nricp.h"
#include "register/quality.h"

namespace {

using namespace keypose;

void Register(benchmark::State& state, bool exact) {
  // 42 x 42 tube: 3,528 + caps faces with a bend of 40 degrees; target meshed otherwise.
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
  std::vector<registration::LandmarkGoal> goals;
  for (int l = 0; l < 13; ++l) {
    registration::LandmarkGoal goal;
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

BENCHMARK_CAPTURE(Register, LaggedFactor, false)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime();
BENCHMARK_CAPTURE(Register, FactorAtEverySolve, true)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime();

}  // namespace
