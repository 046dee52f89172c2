#include "core/values/kept_memory.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <cstring>
#include <memory>

namespace keypose::kept_memory_test {

long Faults() {
  rusage used{};
  getrusage(RUSAGE_SELF, &used);
  return used.ru_minflt;
}

/// Takes, fills and frees 20 MiB, which are 5120 pages.
void UseABlock() {
  constexpr std::size_t kBytes = 20 << 20;
  const std::unique_ptr<char[]> block(new char[kBytes]);
  std::memset(block.get(), 1, kBytes);
  volatile char last = block[kBytes - 1];
  (void)last;
}

TEST(KeepFreedMemory, ABlockThatWasFreedCostsNoFaultsAgain) {
#if defined(KEYPOSE_SANITIZED) || !defined(__GLIBC__)
  GTEST_SKIP() << "another allocator";
#endif
  KeepFreedMemory();
  UseABlock();
  const long before = Faults();
  for (int i = 0; i < 10; ++i) UseABlock();
  EXPECT_LT(Faults() - before, 500) << "of 51200";
}

}  // namespace keypose::kept_memory_test
