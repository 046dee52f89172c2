// Time of interpolation against problem size, 1,000 to 1,000,000 faces and the paper's size (3,490
// triangles there, 120 s in MATLAB), together with its quality. Processor seconds of the whole
// process; wall time depends on free cores.
#include <benchmark/benchmark.h>

#include <cmath>
#include <ctime>
#include <map>
#include <string>

#include "core/surfaces/geometry.h"
#include "core/surfaces/shapes.h"
#include "core/values/camera.h"
#include "interpolate/surface/arap.h"
#include "interpolate/surface/paper_arap.h"

namespace {

using namespace keypose;
using namespace keypose::interpolation;

PointsX3 Bent(const PointsX3& points, double angle) {
  PointsX3 bent = points;
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    const double radius = 2 / angle, a = points(i, 2) / radius, r = radius - points(i, 0);
    bent.row(i) << radius - r * std::cos(a), points(i, 1), r * std::sin(a);
  }
  return bent;
}

PointsX3 Twisted(const PointsX3& points, double angle) {
  PointsX3 twisted = points;
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    const double a = 0.5 * points(i, 2) * angle, x = points(i, 0), y = points(i, 1);
    twisted.row(i) << std::cos(a) * x - std::sin(a) * y, std::sin(a) * x + std::cos(a) * y,
        points(i, 2);
  }
  return twisted;
}

struct Keys {
  explicit Keys(int segments)
      : mesh(MakeCylinder(0.12, 2, segments, 2 * segments - 1)), u(Bent(mesh.points, 2.6)) {}
  Mesh mesh;
  PointsX3 u;
};

double CpuSeconds() {
  timespec now;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Processor seconds against faces, of each kind of work, for the exponents at the end.
std::map<std::string, std::map<double, double>>& Measured() {
  static std::map<std::string, std::map<double, double>> measured;
  return measured;
}

/// Runs the loop and stores the time of one round.
template <class Work>
void Time(benchmark::State& state, const std::string& name, double faces, double rounds,
          const Work& work) {
  const double start = CpuSeconds();
  for (auto _ : state) work();
  const double seconds = (CpuSeconds() - start) / static_cast<double>(state.iterations()) / rounds;
  Measured()[name][faces] = seconds;
  state.counters["cpu_ms"] = 1e3 * seconds;
  state.counters["faces"] = faces;
}

void Quality(benchmark::State& state, const Keys& keys, const PointsX3& middle) {
  const double a0 = SurfaceArea(keys.mesh.points, keys.mesh.faces),
               a1 = SurfaceArea(keys.u, keys.mesh.faces);
  const double v0 = SignedVolume(keys.mesh.points, keys.mesh.faces),
               v1 = SignedVolume(keys.u, keys.mesh.faces);
  const PointsX3 truth = Bent(keys.mesh.points, 1.3);
  state.counters["area_off_path"] = SurfaceArea(middle, keys.mesh.faces) / std::sqrt(a0 * a1) - 1;
  state.counters["volume_off_path"] =
      SignedVolume(middle, keys.mesh.faces) / std::sqrt(v0 * v1) - 1;
  state.counters["error_over_diag"] =
      (Transformed(FitSimilarity(middle, truth, {}, false), middle) - truth)
          .rowwise()
          .norm()
          .mean() /
      BoundingDiagonal(truth);
}

std::vector<double> Times(int count) {
  std::vector<double> times;
  for (int k = 1; k <= count; ++k) times.push_back(static_cast<double>(k) / (count + 1));
  return times;
}

/// Analysis, two factorisations, turns and outward fields.
void Precompute(benchmark::State& state) {
  const Keys keys(static_cast<int>(state.range(0)));
  Time(state, "precompute", keys.mesh.face_count(), 1, [&] {
    benchmark::DoNotOptimize(
        ArapInterpolator(keys.mesh.points, keys.u, keys.mesh.faces).report().closed_parts);
  });
}

/// One frame of a batch of 24, volume corrected.
void FrameInBatch(benchmark::State& state) {
  const Keys keys(static_cast<int>(state.range(0)));
  const ArapInterpolator arap(keys.mesh.points, keys.u, keys.mesh.faces);
  const std::vector<double> times = Times(24);
  std::vector<PointsX3> frames;
  Time(state, "frame", keys.mesh.face_count(), 24, [&] { frames = arap.At(times); });
}

void FrameInBatchWithoutVolume(benchmark::State& state) {
  const Keys keys(static_cast<int>(state.range(0)));
  ArapOptions options;
  options.correct_volume = false;
  const ArapInterpolator arap(keys.mesh.points, keys.u, keys.mesh.faces, options);
  const std::vector<double> times = Times(24);
  std::vector<PointsX3> frames;
  Time(state, "frame_without_volume", keys.mesh.face_count(), 24, [&] { frames = arap.At(times); });
}

/// All steps from two keys to nine frames.
void ArapNineFrames(benchmark::State& state) {
  const Keys keys(static_cast<int>(state.range(0)));
  const std::vector<double> times = Times(9);
  std::vector<PointsX3> frames;
  Time(state, "nine_frames", keys.mesh.face_count(), 1,
       [&] { frames = ArapInterpolator(keys.mesh.points, keys.u, keys.mesh.faces).At(times); });
  Quality(state, keys, frames[4]);
}

void PaperNineFrames(benchmark::State& state) {
  const Keys keys(static_cast<int>(state.range(0)));
  const std::vector<double> times = Times(9);
  std::vector<PointsX3> frames(9);
  Time(state, "paper", keys.mesh.face_count(), 1, [&] {
    const PaperInterpolator paper(keys.mesh.points, keys.u, keys.mesh.faces);
    for (int k = 0; k < 9; ++k) frames[k] = paper.At(times[k]);
  });
  Quality(state, keys, frames[4]);
}

/// Errors at mid-way, over the diagonal: range(0) 0 bends, 1 twists; range(1) degrees; range(2)
/// 1000 * radius / length.
void MidwayError(benchmark::State& state) {
  const Mesh mesh = MakeCylinder(2e-3 * static_cast<double>(state.range(2)), 2, 16, 80);
  const double angle = static_cast<double>(state.range(1)) * 3.141592653589793 / 180;
  const auto pose = [&](double a) {
    return state.range(0) == 1 ? Twisted(mesh.points, a) : Bent(mesh.points, a);
  };
  const PointsX3 end = pose(angle), truth = pose(0.5 * angle);
  PointsX3 middle;
  for (auto _ : state) middle = ArapInterpolator(mesh.points, end, mesh.faces).At(0.5);
  const auto error = [&](const PointsX3& p) {
    return (Transformed(FitSimilarity(p, truth, {}, false), p) - truth).rowwise().norm().mean() /
           BoundingDiagonal(truth);
  };
  state.counters["error_over_diag"] = error(middle);
  state.counters["linear_error_over_diag"] = error(InterpolateLinearly(mesh.points, end, 0.5));
  state.counters["area_off_path"] =
      SurfaceArea(middle, mesh.faces) /
          std::sqrt(SurfaceArea(mesh.points, mesh.faces) * SurfaceArea(end, mesh.faces)) -
      1;
  state.counters["volume_off_path"] =
      SignedVolume(middle, mesh.faces) /
          std::sqrt(SignedVolume(mesh.points, mesh.faces) * SignedVolume(end, mesh.faces)) -
      1;
}

/// Slopes of log seconds over log faces, of what ran before.
void FittedExponents(benchmark::State& state) {
  for (auto _ : state) benchmark::ClobberMemory();
  for (const auto& [name, points] : Measured()) {
    if (points.size() < 3) continue;
    double n = 0, x = 0, y = 0, xx = 0, xy = 0;
    for (const auto& [faces, seconds] : points) {
      const double a = std::log(faces), b = std::log(seconds);
      n += 1, x += a, y += b, xx += a * a, xy += a * b;
    }
    state.counters[name] = (n * xy - x * y) / (n * xx - x * x);
  }
}

// Segments 16, 50, 158, 286, 500: 1,024, 10,000, 99,856, 327,184 and 1,000,000 faces; 30: 3,600.
BENCHMARK(Precompute)
    ->Arg(16)
    ->Arg(50)
    ->Arg(158)
    ->Arg(286)
    ->Arg(500)
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime();
BENCHMARK(FrameInBatch)
    ->Arg(16)
    ->Arg(50)
    ->Arg(158)
    ->Arg(286)
    ->Arg(500)
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime();
BENCHMARK(FrameInBatchWithoutVolume)
    ->Arg(286)
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime();
BENCHMARK(ArapNineFrames)->Arg(30)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime();
BENCHMARK(PaperNineFrames)->Arg(30)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime();
BENCHMARK(MidwayError)
    ->ArgsProduct({{0, 1}, {150, 270, 300, 450, 720, 1000}, {25}})
    ->ArgsProduct({{0, 1}, {150, 270, 300, 450}, {60}})
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);
BENCHMARK(FittedExponents)->Iterations(1);

}  // namespace
