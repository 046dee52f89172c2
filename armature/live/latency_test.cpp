#include "armature/live/latency.h"

#include <gtest/gtest.h>

namespace keypose::armature::latency_test {

TEST(Latency, SharesOfWhatWasMeasured) {
  Latency latency;
  EXPECT_EQ(latency.At(0.5), 0);
  for (int i = 100; i >= 1; --i) latency.Add(i);
  EXPECT_EQ(latency.At(0.5), 50);
  EXPECT_EQ(latency.At(0.99), 99);
  EXPECT_EQ(latency.At(1), 100);
}

}  // namespace keypose::armature::latency_test
