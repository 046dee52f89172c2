#include "core/numbers/max_flow.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>

namespace keypose::max_flow_test {

TEST(MinCut, EqualsTheBestOfAllCuts) {
  std::uint32_t state = 7;
  const auto random = [&](int below) {
    return static_cast<int>((state = state * 1664525u + 1013904223u) >> 16) % below;
  };
  for (int round = 0; round < 50; ++round) {
    constexpr int kNodes = 8;
    std::int64_t source[kNodes], sink[kNodes], arc[kNodes][kNodes] = {};
    MinCut cut(kNodes);
    for (int i = 0; i < kNodes; ++i)
      cut.AddTerminals(i, source[i] = random(10), sink[i] = random(10));
    for (int e = 0; e < 14; ++e) {
      const int a = random(kNodes), b = random(kNodes), forward = random(8), backward = random(8);
      if (a == b) continue;
      cut.AddEdge(a, b, forward, backward);
      arc[a][b] += forward;
      arc[b][a] += backward;
    }
    const auto cost = [&](unsigned with_source) {
      std::int64_t sum = 0;
      for (int i = 0; i < kNodes; ++i) {
        sum += with_source >> i & 1 ? sink[i] : source[i];
        for (int j = 0; j < kNodes; ++j)
          sum += (with_source >> i & 1) && !(with_source >> j & 1) ? arc[i][j] : 0;
      }
      return sum;
    };
    std::int64_t least = cost(0);
    for (unsigned s = 1; s < 1u << kNodes; ++s) least = std::min(least, cost(s));
    unsigned in_all = ~0u;  // nodes on the source's side in every minimum cut
    for (unsigned s = 0; s < 1u << kNodes; ++s)
      if (cost(s) == least) in_all &= s;
    EXPECT_EQ(cut.Solve(), least);
    unsigned chosen = 0;
    for (int i = 0; i < kNodes; ++i) chosen |= static_cast<unsigned>(cut.WithSource(i)) << i;
    EXPECT_EQ(cost(chosen), least);
    EXPECT_EQ(chosen, in_all);
  }
}

}  // namespace keypose::max_flow_test
