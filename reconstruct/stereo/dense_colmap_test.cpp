#include "reconstruct/stereo/dense_colmap.h"

#include <gtest/gtest.h>

namespace keypose::reconstruct::dense_colmap_test {

TEST(ColmapDense, KnowsBuildsWithoutCuda) {
  EXPECT_FALSE(BuiltWithCuda(
      "COLMAP 3.8 -- Structure-from-Motion\n (Commit Unknown on Unknown without CUDA)"));
  EXPECT_TRUE(BuiltWithCuda("COLMAP 3.8 -- Structure-from-Motion\n (Commit 1 on 2023 with CUDA)"));
  EXPECT_FALSE(BuiltWithCuda(""));
}

}  // namespace keypose::reconstruct::dense_colmap_test
