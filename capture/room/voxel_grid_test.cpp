#include "capture/room/voxel_grid.h"

#include <gtest/gtest.h>

namespace keypose::capture::voxel_grid_test {

CoarseDepths TwoViews() {
  const auto at = [](double x, double y, double z) {
    DepthSample sample{};
    sample.point = {x, y, z};
    sample.outward = {0, 0, 1};
    sample.colour.setZero();
    return sample;
  };
  CoarseDepths depths;
  depths.views = {{at(0.1, 0.1, 0.1), at(0.3, 0.3, 0.3), at(9, 0, 0)},
                  {at(0.2, 0.2, 0.2), at(-0.1, 0.1, 0.1)}};
  return depths;
}

TEST(VoxelGrid, SamplesOfOneVoxelAreJoinedInTheOrderOfTheFirst) {
  const VoxelGrid grid(TwoViews(), Eigen::Vector3d::Zero(), 0.5, 5);
  ASSERT_EQ(grid.voxels().size(), 2u);
  const Voxel& joined = grid.voxels()[0];
  EXPECT_EQ(joined.count, 3);
  EXPECT_TRUE(joined.several);
  EXPECT_NEAR((joined.Point() - Eigen::Vector3d(0.2, 0.2, 0.2)).norm(), 0, 1e-12);
  EXPECT_FALSE(grid.voxels()[1].several);
  EXPECT_EQ(grid.voxels()[1].first_view, 1);
}

TEST(VoxelGrid, FindsTheVoxelThatHoldsAPoint) {
  const VoxelGrid grid(TwoViews(), Eigen::Vector3d::Zero(), 0.5, 5);
  EXPECT_EQ(grid.Find({0.45, 0.01, 0.2}), 0);
  EXPECT_EQ(grid.Find({-0.01, 0.01, 0.2}), 1);
  EXPECT_EQ(grid.Find({0.1, 0.1, 0.6}), -1);
  EXPECT_EQ(grid.Find({9, 0, 0}), -1);  // beyond the reach
}

}  // namespace keypose::capture::voxel_grid_test
