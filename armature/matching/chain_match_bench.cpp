// Chains laid along chains: time for one, and how far they are from the curve and its ends.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <ctime>

#include "armature/matching/puppet_match.h"
#include "armature/matching/testing/spines.h"

namespace keypose::armature {
namespace {

constexpr int kChains = 2000;

/// Processor time of this thread [us].
double ThreadMicroseconds() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return 1e6 * static_cast<double>(time.tv_sec) + 1e-3 * static_cast<double>(time.tv_nsec);
}

template <class Match>
void MatchAll(benchmark::State& state, const Match& match) {
  const auto chains = MakeRandomChains(kChains, 5);
  std::vector<Polyline> curves;
  for (const RandomChain& chain : chains) curves.emplace_back(chain.curve);
  double gap = 0, far = 0, distance = 0, iterations = 0, failed = 0;
  // The least of all rounds for each chain, since other programs run beside this one.
  std::vector<double> least_us(kChains, 1e300);
  for (auto _ : state) {
    gap = far = distance = iterations = failed = 0;
    for (int c = 0; c < kChains; ++c) {
      const double begin_us = ThreadMicroseconds();
      const ChainMatch made = match(curves[c], chains[c].lengths);
      least_us[c] = std::min(least_us[c], ThreadMicroseconds() - begin_us);
      const double length = chains[c].lengths.sum();
      gap = std::max({gap, made.near_gap / length, made.far_gap / length});
      far += made.far_gap / length / kChains;
      distance += made.mean_distance / length / kChains;
      iterations += static_cast<double>(made.iterations) / kChains;
      if (!made.reachable || !made.converged) ++failed;
    }
  }
  state.counters["us_a_chain"] = benchmark::Counter(
      1e-6 * kChains, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
  state.counters["worst_anchor_over_length"] = gap;
  state.counters["slowest_chain_us"] = *std::max_element(least_us.begin(), least_us.end());
  state.counters["mean_far_gap_over_length"] = far;
  state.counters["mean_distance_over_length"] = distance;
  state.counters["iterations"] = iterations;
  state.counters["failed"] = failed;
}

void Greedy(benchmark::State& state) {
  MatchAll(state, [](const Polyline& curve, const Eigen::VectorXd& lengths) {
    return MatchGreedily(curve, lengths);
  });
}
BENCHMARK(Greedy)->Unit(benchmark::kMillisecond);

void BothEnds(benchmark::State& state) {
  MatchAll(state, [](const Polyline& curve, const Eigen::VectorXd& lengths) {
    return MatchBothEnds(curve, lengths, {}, nullptr, {});
  });
}
BENCHMARK(BothEnds)->Unit(benchmark::kMillisecond);

/// A spine that moves, each match from the one before.
void SpineInMotion(benchmark::State& state) {
  std::vector<double> physical(14, 10.0 / 14), computer(9, 10.3 / 9);
  const Spine spine = MakeSpine(physical);
  PuppetMatcher matcher(spine.armature, spine.plan, MakeStraightSkeleton(computer), {}, {});
  double time = 0;
  for (auto _ : state) benchmark::DoNotOptimize(matcher.Update(WaveAt(14, 25, time += 0.005)));
}
BENCHMARK(SpineInMotion)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace keypose::armature
