#include "studio/meshes/frame_order.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <vector>

namespace keypose::studio::frame_order_test {

TEST(SortByNumber, NumbersOfFiveDigitsComeAfterThoseOfFour) {
  std::vector<std::filesystem::path> files = {"f/frame_10000.ply", "f/frame_9999.ply",
                                              "f/frame_0002.ply", "f/frame_0010.ply"};
  SortByNumber(&files);
  const std::vector<std::filesystem::path> expected = {"f/frame_0002.ply", "f/frame_0010.ply",
                                                       "f/frame_9999.ply", "f/frame_10000.ply"};
  EXPECT_EQ(files, expected);
}

}  // namespace keypose::studio::frame_order_test
