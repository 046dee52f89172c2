#include "reconstruct/meshing/points.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/values/size_of.h"
#include "reconstruct/meshing/testing/sphere_cloud.h"

namespace keypose::reconstruct::points_test {

TEST(FilterPoints, SparseHullPointsAreNoStraysBesideManyLayers) {
  constexpr double kCell = 0.1;
  PointCloud cloud = UpperCap(SphereCloud(60000), -0.5);
  const PointCloud layer = cloud;
  for (const double lift : {-0.2, -0.1, 0.1, 0.2}) {
    PointCloud more = layer;
    more.points += lift * more.normals;
    cloud = Joined(cloud, more);
  }
  const PointCloud sparse = SphereCloud(2565);  // 3.5 cells apart
  std::vector<int> below;
  for (int i = 0; i < sparse.points.rows(); ++i)
    if (sparse.normals(i, 2) < -0.55) below.push_back(i);
  const FilteredPoints filtered =
      FilterPoints(Joined(cloud, Rows(sparse, below)), {}, kCell, "cloud.ply", nullptr);
  EXPECT_EQ(filtered.removed_outliers, 0);
  int kept = 0;
  for (Eigen::Index i = 0; i < filtered.cloud.points.rows(); ++i)
    kept += filtered.cloud.normals(i, 2) < -0.55;
  EXPECT_EQ(kept, SizeOf(below));
}

}  // namespace keypose::reconstruct::points_test
