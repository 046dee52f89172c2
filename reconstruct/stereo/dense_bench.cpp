// Window correlations per second and kernel, and the entire dense stereo on a rendered ring, with
// its accuracy.
#include <benchmark/benchmark.h>

#include <cmath>

#include "core/numbers/parallel.h"
#include "reconstruct/stereo/dense.h"
#include "reconstruct/testing/rendered_ring.h"
#include "views/stereo/patch_match_cost.h"

namespace keypose::reconstruct {
namespace {

// Windows per second of a kernel by itself. With `near`, all that it reads stays in the L1 cache:
// the arithmetic limit. Without, windows move over an image of 1.5 megapixels as in PatchMatch.
void NccPerSecond(benchmark::State& state) {
  const std::vector<stereo::PatchCostKernel> kernels = stereo::AvailablePatchCostKernels();
  if (state.range(0) >= std::ssize(kernels))
    return state.SkipWithError("this processor has no such kernel");
  const bool near = state.range(1) != 0;
  GreyMask image(1440, 1080, 1);
  for (std::size_t i = 0; i < image.data.size(); ++i)
    image.data[i] = static_cast<std::uint16_t>((i * 2654435761u >> 13) | 1);
  const stereo::SampleImage samples = stereo::MakeSampleImage(image);
  const stereo::SampleImage* sources[stereo::kLanes] = {&samples, &samples, &samples, &samples};
  stereo::RefPatch patch;
  stereo::FillRefPatch(image, 700, 700, stereo::BilateralTable(18), 0.36f, &patch);
  stereo::WarpLanes warps{};
  for (int lane = 0; lane < stereo::kLanes; ++lane) {
    warps.ax[lane] = 0.97f, warps.bx[lane] = -0.08f, warps.ay[lane] = 0.11f, warps.by[lane] = 1.02f;
    warps.ex[lane] = 1e-4f, warps.ey[lane] = -2e-4f;
  }
  std::int64_t k = 0;
  float costs[stereo::kLanes];
  for (auto _ : state) {
    for (int lane = 0; lane < stereo::kLanes; ++lane) {
      warps.x[lane] = 200.3f + (near ? 0.0f : static_cast<float>(k / 8 % 900)) +
                      40.0f * static_cast<float>(lane);
      warps.y[lane] = 300.7f + (near ? 0.0f : static_cast<float>(k / 7200 % 600 + k % 3));
    }
    kernels[state.range(0)].cost(patch, sources, warps, 0, stereo::kLanes, costs);
    benchmark::DoNotOptimize(costs);
    k += stereo::kLanes;
  }
  state.SetLabel(kernels[state.range(0)].name + (near ? ", in cache (roof)" : ", over an image"));
  state.counters["ncc_per_second"] =
      benchmark::Counter(static_cast<double>(k), benchmark::Counter::kIsRate);
}
BENCHMARK(NccPerSecond)->ArgsProduct({{0, 1, 2}, {0, 1}});

void RenderedRing(benchmark::State& state) {
  const testing::RenderedScene scene =
      testing::RenderRing({.views = 16, .size = static_cast<int>(state.range(0))});
  DenseOptions options;
  const std::vector<PreparedView> views = testing::Prepared(scene);
  double masked = 0;
  for (const PreparedView& view : views) masked += 1e-6 * static_cast<double>(view.masked_pixels);
  DenseResult result;
  for (auto _ : state) result = ReconstructDense(views, scene.scene, options);
  const testing::Accuracy accuracy = testing::Measure(scene, result.cloud, result.stereo_points);
  state.counters["matching_cpu_s_per_masked_mp"] = result.matching_cpu_seconds / masked;
  state.counters["ncc_per_cpu_second"] =
      static_cast<double>(result.evaluations) / result.matching_cpu_seconds;
  state.counters["error_footprints_90"] = accuracy.footprints_90;
  state.counters["completeness"] = accuracy.completeness;
  state.counters["points"] = result.stereo_points;
}
BENCHMARK(RenderedRing)->Arg(240)->Arg(480)->Unit(benchmark::kSecond)->Iterations(1);

}  // namespace
}  // namespace keypose::reconstruct
