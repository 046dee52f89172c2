// Volumetric interpolation of a bar twisted by a full turn: each step of the preparation, and a frame, against the number of tetrahedra.
#include <benchmark/benchmark.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/cholesky.h"
#include "core/geometry.h"
#include "core/testing_shapes.h"
#include "interpolate/place_inside.h"
#include "interpolate/tet_maps.h"
#include "interpolate/tetrahedralize.h"
#include "interpolate/volumetric.h"

namespace {

using namespace keypose;
using namespace keypose::interpolation;

constexpr double kRadius = 0.2, kTwist = 2 * std::numbers::pi;

struct Keys {
  explicit Keys(int segments) : mesh(MakeCylinder(kRadius, 2, segments, segments * 8 / 5)), u(mesh.points) {
    for (Eigen::Index i = 0; i < u.rows(); ++i)
      u.row(i) *= Eigen::AngleAxisd(0.5 * kTwist * u(i, 2), Eigen::Vector3d::UnitZ()).toRotationMatrix().transpose();
  }
  Solid Filled() const { return Tetrahedralize(mesh.points, mesh.faces, "bench"); }
  Mesh mesh;
  PointsX3 u;
};

void Fill(benchmark::State& state) {
  const Keys keys(static_cast<int>(state.range(0)));
  Solid solid;
  for (auto _ : state) solid = keys.Filled();
  state.counters["faces"] = keys.mesh.face_count();
  state.counters["tets"] = static_cast<double>(solid.tets.rows());
  double least = 1;  // smallest height over longest edge
  for (Eigen::Index t = 0; t < solid.tets.rows(); ++t) {
    double longest = 0;
    for (int a = 0; a < 4; ++a)
      for (int b = 0; b < a; ++b)
        longest = std::max(longest, (solid.points.row(solid.tets(t, a)) - solid.points.row(solid.tets(t, b))).norm());
    const TetShape shape = TetShapesOf(solid.points, solid.tets.row(t)).front();
    for (int k = 0; k < 4; ++k) least = std::min(least, 1 / (shape.gradients.col(k).norm() * longest));
  }
  state.counters["flattest"] = least;
}

void Place(benchmark::State& state) {
  const Keys keys(static_cast<int>(state.range(0)));
  const Solid solid = keys.Filled();
  const std::vector<TetShape> shapes = TetShapesOf(solid.points, solid.tets);
  PointsX3 placed;
  for (auto _ : state) placed = PlaceInside(solid, shapes, keys.mesh.faces, keys.u);
  int inverted = 0;
  for (const TetMap& map : TetMapsOf(shapes, placed, solid.tets)) inverted += map.inverted;
  state.counters["tets"] = static_cast<double>(solid.tets.rows());
  state.counters["inverted"] = inverted;
}

void AssembleAndFactor(benchmark::State& state) {
  const Keys keys(static_cast<int>(state.range(0)));
  const Solid solid = keys.Filled();
  const std::vector<TetShape> shapes = TetShapesOf(solid.points, solid.tets);
  for (auto _ : state) {
    Eigen::SparseMatrix<double> h = LaplacianOf(solid.points.rows(), solid.tets, shapes, [&](std::int64_t t) -> Eigen::Matrix3d {
      return shapes[t].volume * Eigen::Matrix3d::Identity();
    });
    h.coeffRef(0, 0) += 1;
    SparseCholesky solver;
    solver.Analyze(h);
    solver.Factor(h);
    state.counters["factor_nonzeros"] = static_cast<double>(solver.factor_nonzeros());
  }
  state.counters["tets"] = static_cast<double>(solid.tets.rows());
  state.counters["nodes"] = static_cast<double>(solid.points.rows());
}

void Prepare(benchmark::State& state) {
  const Keys keys(static_cast<int>(state.range(0)));
  for (auto _ : state) benchmark::DoNotOptimize(VolumetricInterpolator(keys.mesh.points, keys.u, keys.mesh.faces).report().tetrahedra);
}

/// Arguments: segments, frames in one batch.
void Frames(benchmark::State& state) {
  const Keys keys(static_cast<int>(state.range(0)));
  const VolumetricInterpolator solid(keys.mesh.points, keys.u, keys.mesh.faces);
  std::vector<double> times;
  for (int k = 1; k <= state.range(1); ++k) times.push_back(static_cast<double>(k) / static_cast<double>(state.range(1) + 1));
  std::vector<PointsX3> frames;
  for (auto _ : state) frames = solid.At(times);
  const PointsX3& middle = frames[frames.size() / 2];
  const double v0 = SignedVolume(keys.mesh.points, keys.mesh.faces), v1 = SignedVolume(keys.u, keys.mesh.faces);
  state.counters["tets"] = solid.report().tetrahedra;
  state.counters["volume_off_path"] = SignedVolume(middle, keys.mesh.faces) / std::sqrt(v0 * v1) - 1;
  const int segments = static_cast<int>(state.range(0)), ring = segments * 8 / 5 / 2;
  Eigen::Vector3d area = Eigen::Vector3d::Zero();
  for (int s = 0; s < segments; ++s) {
    const Eigen::Vector3d o = middle.row(ring * segments), a = middle.row(ring * segments + s),
                          b = middle.row(ring * segments + (s + 1) % segments);
    area += 0.5 * (a - o).cross(b - o);
  }
  state.counters["cross_section"] = area.norm() / (0.5 * segments * kRadius * kRadius * std::sin(2 * std::numbers::pi / segments));
}

void Sizes(benchmark::internal::Benchmark* bench) {
  bench->Arg(24)->Arg(33)->Arg(66)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime();
}
BENCHMARK(Fill)->Apply(Sizes);
BENCHMARK(Place)->Apply(Sizes);
BENCHMARK(AssembleAndFactor)->Apply(Sizes);
BENCHMARK(Prepare)->Apply(Sizes);
BENCHMARK(Frames)->ArgsProduct({{24, 33, 66}, {1, 9}})->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime();

}  // namespace
