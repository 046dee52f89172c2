// Transfers: time on a large scan, a frame by itself, and the error against known poses.
#include <benchmark/benchmark.h>
#include <sys/resource.h>

#include <algorithm>
#include <cmath>

#include "core/surfaces/geometry.h"
#include "core/surfaces/shapes.h"
#include "core/values/angles.h"
#include "motion/testing/rigged_scan.h"
#include "motion/transfer.h"

namespace {

using namespace keypose;
using namespace keypose::motion;

/// A generated scan of 294,000 triangles with 40 marks, and a template of 3,000 that dances.
struct LargeScan {
  LargeScan() : target(MakeCylinder(0.25, 1.8, 384, 382)), small(MakeCylinder(0.25, 1.8, 32, 46)) {
    for (int k = 0; k < 40; ++k) {
      const double z = 0.045 + 0.045 * k * 0.95, angle = 2.4 * k;
      const Eigen::RowVector3d at(0.25 * std::cos(angle), 0.25 * std::sin(angle), z);
      Mark mark;
      mark.name = std::to_string(k);
      mark.on_template.face = FaceNear(small, at);
      mark.on_target.face = FaceNear(target, at);
      marks.push_back(mark);
    }
  }
  PointsX3 Frame(int t) const {
    PointsX3 points = small.points;
    const double sway = std::sin(0.1 * t), twist = 0.8 * std::sin(0.07 * t);
    for (Eigen::Index i = 0; i < points.rows(); ++i) {
      const double z = small.points(i, 2), bend = 0.9 * sway * z, turn = twist * z;
      const double x = std::cos(turn) * small.points(i, 0) - std::sin(turn) * small.points(i, 1),
                   y = std::sin(turn) * small.points(i, 0) + std::cos(turn) * small.points(i, 1);
      points.row(i) << x * std::cos(bend) + 0.5 * bend * z, y, z - x * std::sin(bend);
    }
    return points;
  }
  Mesh target, small;
  std::vector<Mark> marks;
};

const LargeScan& Scan() {
  static const LargeScan scan;
  return scan;
}

TransferOptions OptionsOf(benchmark::State& state) {
  TransferOptions options;
  options.method = state.range(0) == 0 ? TransferMethod::kAuto : TransferMethod::kPaper;
  return options;
}

double PeakMebibytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;
}

/// Of all threads: on a machine that does other things too, a better measure than the clock.
double CoreSeconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
         1e-6 * static_cast<double>(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec);
}

/// All of it but reading and writing: fields, factors, 330 frames.
void LargeScanAllFrames(benchmark::State& state) {
  const LargeScan& scan = Scan();
  const double volume = SignedVolume(scan.target.points, scan.target.faces);
  double deviation = 0;
  const double before = CoreSeconds();
  for (auto _ : state) {
    Transfer transfer(scan.target, scan.small.points, scan.small.faces, scan.marks,
                      OptionsOf(state));
    for (int t = 0; t < 330; ++t) transfer.Add(scan.Frame(t), "frame");
    transfer.Run([&](int t, const PointsX3& points) {
      benchmark::DoNotOptimize(points.data());
      if (t % 30 == 29)
        deviation =
            std::max(deviation, std::abs(SignedVolume(points, scan.target.faces) / volume - 1));
    });
  }
  state.counters["faces"] = scan.target.face_count();
  state.counters["frames"] = 330;
  state.counters["volume_deviation"] = deviation;
  state.counters["core_seconds"] = CoreSeconds() - before;
  state.counters["peak_mib"] = PeakMebibytes();
}

void LargeScanSetUp(benchmark::State& state) {
  const LargeScan& scan = Scan();
  const double before = CoreSeconds();
  for (auto _ : state)
    benchmark::DoNotOptimize(
        Transfer(scan.target, scan.small.points, scan.small.faces, scan.marks, OptionsOf(state)));
  state.counters["core_seconds"] =
      benchmark::Counter(CoreSeconds() - before, benchmark::Counter::kAvgIterations);
}

void LargeScanOneFrame(benchmark::State& state) {
  const LargeScan& scan = Scan();
  Transfer transfer(scan.target, scan.small.points, scan.small.faces, scan.marks, OptionsOf(state));
  for (int t = 0; t < 30; ++t) transfer.Add(scan.Frame(t), "frame");
  benchmark::DoNotOptimize(transfer.Frame(0));
  int t = 0;
  const double before = CoreSeconds();
  for (auto _ : state) benchmark::DoNotOptimize(transfer.Frame(++t % 30));
  state.counters["core_seconds"] =
      benchmark::Counter(CoreSeconds() - before, benchmark::Counter::kAvgIterations);
}

BENCHMARK(LargeScanAllFrames)
    ->Arg(0)
    ->Arg(1)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime()
    ->Iterations(1);
BENCHMARK(LargeScanSetUp)->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(LargeScanOneFrame)->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond)->UseRealTime();

/// Errors over the diagonal. 0: auto, 1: paper, 2: linear blend skinning by the nearest mark.
void KnownPoses(benchmark::State& state) {
  const std::optional<RiggedScan> scan = LoadRiggedScan(static_cast<int>(state.range(1)));
  if (!scan) return state.SkipWithError("motion/rigs/cheburashka is not here; set KEYPOSE_DATA");
  PoseError error;
  for (auto _ : state) {
    std::vector<PointsX3> poses;
    if (state.range(0) == 2) {
      poses = NearestMarkSkinning(*scan);
    } else {
      TransferOptions options = OptionsOf(state);
      options.feet = false;
      Transfer transfer(scan->target, scan->reference, scan->faces, scan->marks, options);
      for (const PointsX3& frame : scan->frames) transfer.Add(frame, "frame");
      transfer.Run([&](int, const PointsX3& points) { poses.push_back(points); });
    }
    error = ErrorOf(*scan, poses);
  }
  state.counters["mean_over_diag"] = error.mean;
  state.counters["worst_pose"] = error.worst;
  state.counters["furthest_vertex"] = error.furthest;
}
BENCHMARK(KnownPoses)
    ->ArgsProduct({{0, 1, 2}, {20, 40, 80}})
    ->Unit(benchmark::kMillisecond)
    ->Iterations(1);

/// Volume that an arm has lost when its elbow is bent by 120 degrees.
void BentElbow(benchmark::State& state) {
  const BentArm arm = MakeBentArm(120 * kDegree);
  PointsX3 pose;
  for (auto _ : state) {
    TransferOptions options = OptionsOf(state);
    options.feet = false;
    Transfer transfer(arm.arm, arm.arm.points, arm.arm.faces, arm.marks, options);
    transfer.Add(arm.bent, "bent");
    transfer.Run([&](int, const PointsX3& points) { pose = points; });
  }
  state.counters["volume_lost"] =
      1 - SignedVolume(pose, arm.arm.faces) / SignedVolume(arm.arm.points, arm.arm.faces);
}
BENCHMARK(BentElbow)->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond)->Iterations(1);

}  // namespace
