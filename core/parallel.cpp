#include "core/parallel.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <atomic>
#include <cstdlib>
#include <thread>

namespace keypose {
namespace {

std::atomic<int> g_override{0};

int DefaultThreads() {
  if (const char* text = std::getenv("KEYPOSE_THREADS")) {
    const int wanted = std::atoi(text);
    if (wanted > 0) return wanted;
  }
  return std::max(1u, std::thread::hardware_concurrency());
}

}  // namespace

int ThreadCount() {
  static const int by_default = DefaultThreads();
  const int override_count = g_override.load();
  return override_count > 0 ? override_count : by_default;
}

void SetThreadCount(int threads) { g_override = threads; }

void ParallelBlocks(std::int64_t count, std::int64_t grain, const std::function<void(std::int64_t, std::int64_t)>& body) {
  if (count <= 0) return;
  const std::int64_t blocks = (count + grain - 1) / grain;
  const auto run_block = [&](std::int64_t b) { body(b * grain, std::min(count, (b + 1) * grain)); };
  if (blocks == 1 || ThreadCount() == 1) {
    for (std::int64_t b = 0; b < blocks; ++b) run_block(b);
    return;
  }
  // Blocks are cut here and not by the scheduler, so that per-block sums have the same extent for any thread count.
  tbb::task_arena arena(ThreadCount());
  arena.execute([&] {
    tbb::parallel_for(
        tbb::blocked_range<std::int64_t>(0, blocks, 1),
        [&](const tbb::blocked_range<std::int64_t>& range) {
          for (std::int64_t b = range.begin(); b != range.end(); ++b) run_block(b);
        },
        tbb::simple_partitioner());
  });
}

void ParallelFor(std::int64_t count, const std::function<void(std::int64_t)>& body, std::int64_t grain) {
  ParallelBlocks(count, grain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) body(i);
  });
}

}  // namespace keypose
