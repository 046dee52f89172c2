#include "reconstruct/meshing/merge.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "reconstruct/meshing/testing/sphere_cloud.h"

namespace keypose::reconstruct::merge_test {

TEST(MergeWithinCells, MeanOfACellIsWeightedByConfidenceSquared) {
  PointCloud cloud = SphereCloud(4);
  cloud.points << 0, 0, 0, 0.3, 0, 0, 0.3, 0, 0, 2, 0, 0;
  cloud.normals << 0, 0, 1, 0, 0, 1, 0, 0, -1, 0, 0,
      1;  // the third is on the other side of a thin sheet
  cloud.confidence = Eigen::Vector4f(1, 0.5f, 0.25f, 0.75f);
  const PointCloud merged = MergeWithinCells(cloud, 1);
  ASSERT_EQ(merged.points.rows(), 3);
  EXPECT_NEAR(merged.points.col(0).sum(), 0.3 * 0.25 / 1.25 + 0.3 + 2, 1e-12);
  EXPECT_NEAR(merged.confidence.sum(), 1.25 / 1.5 + 0.25 + 0.75, 1e-6);
  EXPECT_EQ(merged.normals.col(2).sum(), 1);
}

TEST(MergeWithinCells, PointsApartKeepTheirValues) {
  const PointCloud cloud = SphereCloud(500);
  const PointCloud merged = MergeWithinCells(cloud, 1e-3);
  ASSERT_EQ(merged.points.rows(), cloud.points.rows());
  EXPECT_NEAR((merged.points.colwise().sum() - cloud.points.colwise().sum()).norm(), 0, 1e-9);
}

}  // namespace keypose::reconstruct::merge_test
