// Volumetric interpolation of a bar twisted by a full turn: the time of each step of the
// preparation and of a frame, against the number of tetrahedra. Also the error of the middle frames
// of bends and twists, compared with the surface method and the paper's.
#include <benchmark/benchmark.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "core/numbers/cholesky.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/shapes.h"
#include "core/values/camera.h"
#include "interpolate/surface/arap.h"
#include "interpolate/volume/place_inside.h"
#include "interpolate/volume/tet_maps.h"
#include "interpolate/volume/tetrahedralize.h"
#include "interpolate/volume/volumetric.h"

namespace {

using namespace keypose;
using namespace keypose::interpolation;

constexpr double kRadius = 0.2, kTwist = 2 * std::numbers::pi;

struct Keys {
  explicit Keys(int segments)
      : mesh(MakeCylinder(kRadius, 2, segments, segments * 8 / 5)), u(mesh.points) {
    for (Eigen::Index i = 0; i < u.rows(); ++i)
      u.row(i) *= Eigen::AngleAxisd(0.5 * kTwist * u(i, 2), Eigen::Vector3d::UnitZ())
                      .toRotationMatrix()
                      .transpose();
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
        longest = std::max(
            longest,
            (solid.points.row(solid.tets(t, a)) - solid.points.row(solid.tets(t, b))).norm());
    const TetShape shape = TetShapesOf(solid.points, solid.tets.row(t)).front();
    for (int k = 0; k < 4; ++k)
      least = std::min(least, 1 / (shape.gradients.col(k).norm() * longest));
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
    Eigen::SparseMatrix<double> h = LaplacianOf(
        solid.points.rows(), solid.tets, shapes, [&](std::int64_t t) -> Eigen::Matrix3d {
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
  for (auto _ : state)
    benchmark::DoNotOptimize(
        VolumetricInterpolator(keys.mesh.points, keys.u, keys.mesh.faces).report().tetrahedra);
}

/// Arguments: segments, frames in one batch.
void Frames(benchmark::State& state) {
  const Keys keys(static_cast<int>(state.range(0)));
  const VolumetricInterpolator solid(keys.mesh.points, keys.u, keys.mesh.faces);
  std::vector<double> times;
  for (int k = 1; k <= state.range(1); ++k)
    times.push_back(static_cast<double>(k) / static_cast<double>(state.range(1) + 1));
  std::vector<PointsX3> frames;
  for (auto _ : state) frames = solid.At(times);
  const PointsX3& middle = frames[frames.size() / 2];
  const double v0 = SignedVolume(keys.mesh.points, keys.mesh.faces),
               v1 = SignedVolume(keys.u, keys.mesh.faces);
  state.counters["tets"] = solid.report().tetrahedra;
  state.counters["volume_off_path"] =
      SignedVolume(middle, keys.mesh.faces) / std::sqrt(v0 * v1) - 1;
  const int segments = static_cast<int>(state.range(0)), ring = segments * 8 / 5 / 2;
  Eigen::Vector3d area = Eigen::Vector3d::Zero();
  for (int s = 0; s < segments; ++s) {
    const Eigen::Vector3d o = middle.row(ring * segments), a = middle.row(ring * segments + s),
                          b = middle.row(ring * segments + (s + 1) % segments);
    area += 0.5 * (a - o).cross(b - o);
  }
  state.counters["cross_section"] = area.norm() / (0.5 * segments * kRadius * kRadius *
                                                   std::sin(2 * std::numbers::pi / segments));
}

/// A bar of length 2: square across and twisted, or round and bent.
Mesh Bar(double radius, bool square) {
  Mesh mesh = MakeCylinder(radius, 2, 24, 40);
  for (Eigen::Index i = 0; square && i < mesh.points.rows(); ++i) {
    const double reach = std::max(std::abs(mesh.points(i, 0)), std::abs(mesh.points(i, 1)));
    if (reach > 0) mesh.points.row(i).head<2>() *= radius / reach;
  }
  return mesh;
}

PointsX3 Twisted(PointsX3 p, double angle) {
  for (Eigen::Index i = 0; i < p.rows(); ++i)
    p.row(i) *= Eigen::AngleAxisd(0.5 * angle * p(i, 2), Eigen::Vector3d::UnitZ())
                    .toRotationMatrix()
                    .transpose();
  return p;
}

PointsX3 Bent(PointsX3 p, double angle) {
  const double radius = 2 / angle;
  for (Eigen::Index i = 0; i < p.rows(); ++i) {
    const double a = p(i, 2) / radius, r = radius - p(i, 0);
    p.row(i) << radius - r * std::cos(a), p(i, 1), r * std::sin(a);
  }
  return p;
}

/// Arguments: 0 twist, 1 bend; degrees; thousandths of the bar's half width.
void KnownWays(benchmark::State& state) {
  const bool bend = state.range(0) == 1;
  const double angle = static_cast<double>(state.range(1)) * std::numbers::pi / 180;
  const Mesh mesh = Bar(static_cast<double>(state.range(2)) / 1000, !bend);
  const PointsX3 u = bend ? Bent(mesh.points, angle) : Twisted(mesh.points, angle);
  const PointsX3 exact = bend ? Bent(mesh.points, angle / 2) : Twisted(mesh.points, angle / 2);
  PointsX3 solid;
  for (auto _ : state) solid = VolumetricInterpolator(mesh.points, u, mesh.faces).At(0.5);
  const auto report = [&](const std::string& name, const PointsX3& frame) {
    const PointsX3 laid = Transformed(FitSimilarity(frame, exact, {}, false), frame);
    state.counters[name + "_error"] =
        (laid - exact).rowwise().norm().mean() / BoundingDiagonal(exact);
    double least = 1e9;
    for (int r = 2; r <= 38; ++r) {
      Eigen::Vector3d now = Eigen::Vector3d::Zero(), rest = Eigen::Vector3d::Zero();
      for (int s = 0; s < 24; ++s) {
        const int o = r * 24, a = o + s, b = o + (s + 1) % 24;
        now += Eigen::Vector3d(frame.row(a) - frame.row(o))
                   .cross(Eigen::Vector3d(frame.row(b) - frame.row(o)));
        rest += Eigen::Vector3d(exact.row(a) - exact.row(o))
                    .cross(Eigen::Vector3d(exact.row(b) - exact.row(o)));
      }
      least = std::min(least, now.norm() / rest.norm());
    }
    state.counters[name + "_section"] = least;
  };
  report("solid", solid);
  report("shell", ArapInterpolator(mesh.points, u, mesh.faces).At(0.5));
  report("paper", ArapInterpolator(mesh.points, u, mesh.faces, PaperOptions()).At(0.5));
}

void Sizes(benchmark::internal::Benchmark* bench) {
  bench->Arg(24)->Arg(33)->Arg(66)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime();
}
BENCHMARK(Fill)->Apply(Sizes);
BENCHMARK(Place)->Apply(Sizes);
BENCHMARK(AssembleAndFactor)->Apply(Sizes);
BENCHMARK(Prepare)->Apply(Sizes);
BENCHMARK(Frames)
    ->ArgsProduct({{24, 33, 66}, {1, 9}})
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime();

BENCHMARK(KnownWays)
    ->ArgsProduct({{0}, {180, 360, 720}, {80, 120, 160, 200}})
    ->ArgsProduct({{1}, {150, 300, 450, 720}, {120}})
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime();

}  // namespace
