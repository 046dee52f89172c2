// Interpolation at the paper's size (3,490 triangles there, 120 s in MATLAB) and larger.
#include <benchmark/benchmark.h>

#include <cmath>

#include "core/geometry.h"
#include "core/testing_shapes.h"
#include "interpolate/arap.h"
#include "interpolate/paper_arap.h"

namespace {

using namespace keypose;
using namespace keypose::interpolation;

struct Keys {
  explicit Keys(int segments) : mesh(MakeCylinder(0.12, 2, segments, 2 * segments - 1)), u(mesh.points) {
    for (Eigen::Index i = 0; i < u.rows(); ++i) {
      const double radius = 2 / 2.6, a = mesh.points(i, 2) / radius, r = radius - mesh.points(i, 0);
      u.row(i) << radius - r * std::cos(a), mesh.points(i, 1), r * std::sin(a);
    }
  }
  Mesh mesh;
  PointsX3 u;
};

void Report(benchmark::State& state, const Keys& keys, const PointsX3& middle) {
  const double a0 = SurfaceArea(keys.mesh.points, keys.mesh.faces), a1 = SurfaceArea(keys.u, keys.mesh.faces);
  const double v0 = SignedVolume(keys.mesh.points, keys.mesh.faces), v1 = SignedVolume(keys.u, keys.mesh.faces);
  state.counters["faces"] = keys.mesh.face_count();
  state.counters["area_off_path"] = SurfaceArea(middle, keys.mesh.faces) / std::sqrt(a0 * a1) - 1;
  state.counters["volume_off_path"] = SignedVolume(middle, keys.mesh.faces) / std::sqrt(v0 * v1) - 1;
}

const std::vector<double> kNine = {0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9};

void ArapNineFrames(benchmark::State& state) {
  const Keys keys(static_cast<int>(state.range(0)));
  std::vector<PointsX3> frames;
  for (auto _ : state) frames = ArapInterpolator(keys.mesh.points, keys.u, keys.mesh.faces).At(kNine);
  Report(state, keys, frames[4]);
}

void ArapOneFrame(benchmark::State& state) {
  const Keys keys(static_cast<int>(state.range(0)));
  const ArapInterpolator arap(keys.mesh.points, keys.u, keys.mesh.faces);
  PointsX3 frame;
  for (auto _ : state) frame = arap.At(0.5);
  Report(state, keys, frame);
}

void PaperNineFrames(benchmark::State& state) {
  const Keys keys(static_cast<int>(state.range(0)));
  std::vector<PointsX3> frames(9);
  for (auto _ : state) {
    const PaperInterpolator paper(keys.mesh.points, keys.u, keys.mesh.faces);
    for (int k = 0; k < 9; ++k) frames[k] = paper.At(kNine[k]);
  }
  Report(state, keys, frames[4]);
}

BENCHMARK(ArapNineFrames)->Arg(30)->Arg(120)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime();
BENCHMARK(ArapOneFrame)->Arg(30)->Arg(120)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime();
BENCHMARK(PaperNineFrames)->Arg(30)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime();

}  // namespace
