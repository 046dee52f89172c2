// How many window correlations a second, per kernel; and the whole of dense stereo on a rendered ring, with its accuracy.
#include <benchmark/benchmark.h>

#include <cmath>

#include "core/parallel.h"
#include "reconstruct/dense.h"
#include "reconstruct/dense_test_scene.h"
#include "reconstruct/patch_match_cost.h"

namespace keypose::reconstruct {
namespace {

void NccPerSecond(benchmark::State& state) {
  const std::vector<PatchCostKernel> kernels = AvailablePatchCostKernels();
  if (state.range(0) >= static_cast<int>(kernels.size())) return state.SkipWithError("this processor has no such kernel");
  GreyMask image(2000, 1500, 1);
  for (std::size_t i = 0; i < image.data.size(); ++i) image.data[i] = static_cast<std::uint16_t>((i * 2654435761u >> 13) | 1);
  RefPatch patch;
  FillRefPatch(image, 700, 700, BilateralTable(18), &patch);
  int k = 0;
  for (auto _ : state) {
    const float x = 400.0f + static_cast<float>(k * 37 % 600), y = 300.0f + static_cast<float>(k / 600 % 600);
    const PatchWarp warp{{x, y, 1}, {0.97f, 0.11f, 1e-5f}, {-0.08f, 1.02f, 2e-5f}};
    benchmark::DoNotOptimize(kernels[state.range(0)].cost(patch, image, warp, 0.36f));
    ++k;
  }
  state.SetLabel(kernels[state.range(0)].name);
  state.counters["ncc_per_second"] = benchmark::Counter(static_cast<double>(k), benchmark::Counter::kIsRate);
}
BENCHMARK(NccPerSecond)->DenseRange(0, 2);

void RenderedRing(benchmark::State& state) {
  const testing::RenderedScene scene = testing::RenderRing({.views = 16, .size = static_cast<int>(state.range(0))});
  DenseOptions options;
  const std::vector<DenseView> views = testing::Prepared(scene, options);
  double masked = 0;
  for (const DenseView& view : views) masked += 1e-6 * static_cast<double>(view.masked_pixels);
  DenseResult result;
  for (auto _ : state) result = ReconstructDense(views, scene.scene, options);
  const testing::Accuracy accuracy = testing::Measure(scene, result.cloud, result.stereo_points);
  state.counters["matching_cpu_s_per_masked_mp"] = result.matching_cpu_seconds / masked;
  state.counters["ncc_per_cpu_second"] = static_cast<double>(result.evaluations) / result.matching_cpu_seconds;
  state.counters["error_footprints_90"] = accuracy.footprints_90;
  state.counters["completeness"] = accuracy.completeness;
  state.counters["points"] = result.stereo_points;
}
BENCHMARK(RenderedRing)->Arg(240)->Arg(480)->Unit(benchmark::kSecond)->Iterations(1);

}  // namespace
}  // namespace keypose::reconstruct
