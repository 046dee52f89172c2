// Loops over all cores. A body must only write to its own index; then results do not depend on the
// thread count.
#pragma once

#include <cstdint>
#include <functional>

namespace keypose {

/// Number of threads that ParallelFor uses: KEYPOSE_THREADS when set, else the machine's number.
int ThreadCount();
/// Overrides it for this process; 0 restores the default. For tests and benchmarks.
void SetThreadCount(int threads);

/// Calls body(i) for i in [0, count), in any order, on ThreadCount() threads, `grain` indices at a
/// time. The first exception is rethrown.
void ParallelFor(std::int64_t count, const std::function<void(std::int64_t)>& body,
                 std::int64_t grain = 1);

/// Calls body(begin, end) for consecutive blocks of at most `grain` indices; cheaper per index than
/// ParallelFor.
void ParallelBlocks(std::int64_t count, std::int64_t grain,
                    const std::function<void(std::int64_t, std::int64_t)>& body);

}  // namespace keypose
