#include "core/numbers/parallel.h"

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <cstdlib>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

#include "core/values/size_of.h"

namespace keypose {
namespace {

std::atomic<int> g_override{0};
// A nested loop runs on the thread that calls it.
thread_local bool t_inside_loop = false;

int DefaultThreads() {
  if (const char* text = std::getenv("KEYPOSE_THREADS")) {
    const int wanted = std::atoi(text);
    if (wanted > 0) return wanted;
  }
  return static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
}

/// A pool of threads that sleep between loops. TBB is not used: Embree shares TBB's single pool and
/// its limits, and in tests left our loops a single thread for the rest of the process.
class Pool {
 public:
  ~Pool() {
    {
      const std::lock_guard lock(mutex_);
      stop_ = true;
    }
    wake_.notify_all();
    for (std::thread& thread : threads_) thread.join();
  }

  /// Calls run_block(b) for b in [0, blocks) on `participants` threads, including the calling one.
  void Run(std::int64_t blocks, int participants,
           const std::function<void(std::int64_t)>& run_block) {
    const std::lock_guard one_loop(loop_mutex_);
    {
      const std::lock_guard lock(mutex_);
      while (SizeOf(threads_) < participants - 1) threads_.emplace_back([this] { Work(); });
      run_block_ = &run_block;
      blocks_ = blocks;
      next_ = 0;
      failure_ = nullptr;
      seats_ = participants - 1;
      ++generation_;
    }
    wake_.notify_all();
    TakeBlocks();
    std::unique_lock lock(mutex_);
    seats_ = 0;
    done_.wait(lock, [this] { return working_ == 0; });
    run_block_ = nullptr;
    if (failure_) std::rethrow_exception(failure_);
  }

 private:
  void TakeBlocks() {
    t_inside_loop = true;
    for (std::int64_t b = next_++; b < blocks_; b = next_++) {
      try {
        (*run_block_)(b);
      } catch (...) {
        const std::lock_guard lock(mutex_);
        if (!failure_) failure_ = std::current_exception();
        next_ = blocks_;
      }
    }
    t_inside_loop = false;
  }

  void Work() {
    std::int64_t seen = 0;
    std::unique_lock lock(mutex_);
    for (;;) {
      wake_.wait(lock, [&] { return stop_ || (generation_ != seen && seats_ > 0); });
      if (stop_) return;
      seen = generation_;
      --seats_;
      ++working_;
      lock.unlock();
      TakeBlocks();
      lock.lock();
      if (--working_ == 0) done_.notify_all();
    }
  }

  std::mutex loop_mutex_, mutex_;
  std::condition_variable wake_, done_;
  std::vector<std::thread> threads_;
  const std::function<void(std::int64_t)>* run_block_ = nullptr;
  std::atomic<std::int64_t> next_{0};
  std::int64_t blocks_ = 0, generation_ = 0;
  int seats_ = 0, working_ = 0;
  bool stop_ = false;
  std::exception_ptr failure_;
};

}  // namespace

int ThreadCount() {
  static const int by_default = DefaultThreads();
  const int override_count = g_override.load();
  return override_count > 0 ? override_count : by_default;
}

void SetThreadCount(int threads) { g_override = threads; }

void ParallelBlocks(std::int64_t count, std::int64_t grain,
                    const std::function<void(std::int64_t, std::int64_t)>& body) {
  if (count <= 0) return;
  // Blocks depend on count and grain only, so that sums per block are the same for any thread
  // count.
  const std::int64_t blocks = (count + grain - 1) / grain;
  const auto run_block = [&](std::int64_t b) { body(b * grain, std::min(count, (b + 1) * grain)); };
  const int participants = static_cast<int>(std::min<std::int64_t>(ThreadCount(), blocks));
  if (participants <= 1 || t_inside_loop) {
    for (std::int64_t b = 0; b < blocks; ++b) run_block(b);
    return;
  }
  static Pool pool;
  pool.Run(blocks, participants, run_block);
}

void ParallelFor(std::int64_t count, const std::function<void(std::int64_t)>& body,
                 std::int64_t grain) {
  ParallelBlocks(count, grain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) body(i);
  });
}

}  // namespace keypose
