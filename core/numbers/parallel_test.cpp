#include "core/numbers/parallel.h"

#include <gtest/gtest.h>

#include "core/values/errors.h"

namespace keypose::parallel_test {

TEST(ParallelFor, VisitsEachIndexOnceAndRethrows) {
  for (const int threads : {1, 2, 5}) {
    SetThreadCount(threads);
    std::vector<int> visits(1000, 0);
    ParallelFor(
        1000, [&](std::int64_t i) { ++visits[i]; }, 7);
    EXPECT_EQ(std::count(visits.begin(), visits.end(), 1), 1000);
    EXPECT_THROW(ParallelFor(10,
                             [](std::int64_t i) {
                               if (i == 3) throw InputError("three");
                             }),
                 InputError);
  }
  SetThreadCount(0);
}

}  // namespace keypose::parallel_test
