// From simulated counters to a posed mesh, 200 times a second: 74 sensors, six chains, 100,000
// vertices. Counters of a simulated controller box reach the program over a pseudo terminal.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <thread>

#include "armature/controller/armature_reader.h"
#include "armature/example/theropod.h"
#include "armature/example/theropod_body.h"
#include "armature/live/latency.h"
#include "armature/live/posed_puppet.h"
#include "armature/simulation/simulated_box.h"
#include "armature/skinning/bone_heat.h"

namespace keypose::armature {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kVertices = 100000;
constexpr double kRate = 200;

/// KEYPOSE_LIVE_SECONDS asks for more than the usual 20.
double WantedSeconds() {
  const char* wanted = std::getenv("KEYPOSE_LIVE_SECONDS");
  return wanted ? std::max(1.0, std::atof(wanted)) : 20;
}

double Seconds(Clock::time_point a, Clock::time_point b) {
  return std::chrono::duration<double>(b - a).count();
}

PuppetParts TheropodWithBody() {
  PuppetParts parts;
  parts.armature = MakeTheropod();
  parts.plan = MakeTheropodChains(parts.armature);
  parts.skeleton = SkeletonOfClip(MakeTheropodSkeleton(), false);
  parts.world_from_armature = PlacementOf(parts.armature, parts.plan, parts.skeleton, false);
  parts.mesh = MakeTheropodBody(kVertices);
  parts.weights = HeatWeights(parts.mesh, SkinBonesOf(parts.skeleton)).weights;
  return parts;
}

/// Only the time of the program that reads: the simulated box has threads of its own.
double ThreadSeconds() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

void Report(benchmark::State& state, const std::string& name, const Latency& latency) {
  state.counters[name + "_p50_ms"] = 1e3 * latency.At(0.5);
  state.counters[name + "_p99_ms"] = 1e3 * latency.At(0.99);
  state.counters[name + "_most_ms"] = 1e3 * latency.At(1);
}

void SensorsToMesh(benchmark::State& state) {
  const PuppetParts parts = TheropodWithBody();
  const auto port =
      std::filesystem::temp_directory_path() / ("keypose-bench-" + std::to_string(getpid()));
  SimulatedBox box(parts.armature, port, {});
  PortOptions options;
  options.device = port.string();
  ArmatureReader reader(parts.armature, options, {});
  PosedPuppet puppet(parts);
  for (auto _ : state) {
    Latency whole, pose, processor;
    const double seconds = WantedSeconds();
    long missed = 0, unanswered = 0;
    const auto begin = Clock::now();
    auto due = begin;
    const auto period =
        std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(1 / kRate));
    while (Seconds(begin, due) < seconds) {
      box.SetValues(TheropodWalk(parts.armature, Seconds(begin, due)));
      const double processor_before = ThreadSeconds();
      const auto asked = Clock::now();
      const Reading& reading = reader.Poll();
      const auto read = Clock::now();
      puppet.Update(reading.values);
      unanswered += !reading.fresh;
      const auto posed = Clock::now();
      processor.Add(ThreadSeconds() - processor_before);
      whole.Add(Seconds(asked, posed));
      pose.Add(Seconds(read, posed));
      due += period;
      for (; due + period < Clock::now(); due += period) ++missed;
      std::this_thread::sleep_until(due);
    }
    Report(state, "counters_to_mesh", whole);
    Report(state, "values_to_mesh", pose);
    Report(state, "processor", processor);
    state.counters["updates"] = whole.count();
    state.counters["missed"] = static_cast<double>(missed);
    state.counters["unanswered"] = static_cast<double>(unanswered);
    state.counters["vertices"] = parts.mesh.vertex_count();
    state.counters["sensors"] = static_cast<double>(parts.armature.joints.size());
  }
}
BENCHMARK(SensorsToMesh)->Iterations(1)->Unit(benchmark::kSecond);

/// As fast as it goes, without a port: what the program itself needs.
void ValuesToMesh(benchmark::State& state) {
  const PuppetParts parts = TheropodWithBody();
  PosedPuppet puppet(parts);
  double time = 0;
  for (auto _ : state) puppet.Update(TheropodWalk(parts.armature, time += 1 / kRate));
}
BENCHMARK(ValuesToMesh)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime()->UseRealTime();

/// The same, but only the neck moves: one chain is matched.
void OneChainToMesh(benchmark::State& state) {
  const PuppetParts parts = TheropodWithBody();
  PosedPuppet puppet(parts);
  auto values = TheropodWalk(parts.armature, 0);
  const auto joint =
      static_cast<std::size_t>(parts.armature.JointOf(parts.armature.Find("trunkBend8")));
  for (auto _ : state) {
    values[joint] += 1e-3;
    puppet.Update(values);
  }
  state.counters["matched"] = puppet.matcher().matched();
  state.counters["match_ms"] = 1e3 * puppet.match_s();
}
BENCHMARK(OneChainToMesh)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime()->UseRealTime();

}  // namespace
}  // namespace keypose::armature
