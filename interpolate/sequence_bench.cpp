// Smooth sequences through three keys: time of the setup, and of one more frame of a batch, against
// problem size.
#include <benchmark/benchmark.h>

#include <cmath>

#include "core/surfaces/geometry.h"
#include "core/surfaces/shapes.h"
#include "interpolate/surface/key_source.h"

namespace {

using namespace keypose;
using namespace keypose::interpolation;

struct Keys {
  explicit Keys(int segments) : mesh(MakeCylinder(0.12, 2, segments, 2 * segments - 1)) {
    points = {mesh.points, Bent(1.5), Bent(2.6)};
    schedule = MakeSchedule({16, 16});
  }
  PointsX3 Bent(double angle) const {
    PointsX3 bent = mesh.points;
    const double radius = 2 / angle;
    for (Eigen::Index i = 0; i < bent.rows(); ++i) {
      const double a = mesh.points(i, 2) / radius, r = radius - mesh.points(i, 0);
      bent.row(i) << radius - r * std::cos(a), mesh.points(i, 1), r * std::sin(a);
    }
    return bent;
  }
  Mesh mesh;
  std::vector<PointsX3> points;
  Schedule schedule;
};

void SetUp(benchmark::State& state) {
  const Keys keys(static_cast<int>(state.range(0)));
  for (auto _ : state)
    benchmark::DoNotOptimize(
        KeySource(keys.points, keys.mesh.faces, keys.schedule, PlainRules(keys.schedule, true)));
  state.counters["faces"] = keys.mesh.face_count();
}

void EightFrames(benchmark::State& state) {
  const Keys keys(static_cast<int>(state.range(0)));
  KeySource source(keys.points, keys.mesh.faces, keys.schedule, PlainRules(keys.schedule, true));
  std::vector<ComputedFrame> frames;
  for (auto _ : state) frames = source.At(1, {0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8});
  const auto off = [&](auto measure) {
    return measure(frames[4].points, keys.mesh.faces) /
               std::sqrt(measure(keys.points[1], keys.mesh.faces) *
                         measure(keys.points[2], keys.mesh.faces)) -
           1;
  };
  state.counters["faces"] = keys.mesh.face_count();
  state.counters["area_off_middle"] = off(SurfaceArea);
  state.counters["volume_off_middle"] = off(SignedVolume);
}

BENCHMARK(SetUp)
    ->Arg(30)
    ->Arg(120)
    ->Arg(286)
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime();
BENCHMARK(EightFrames)
    ->Arg(30)
    ->Arg(120)
    ->Arg(286)
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime();

}  // namespace
