#include "reconstruct/cloud/cloud_rows.h"

#include <gtest/gtest.h>

namespace keypose::reconstruct::cloud_rows_test {

PointCloud Numbered(int count) {
  PointCloud cloud;
  cloud.points.resize(count, 3);
  cloud.normals.resize(count, 3);
  cloud.colors.resize(count, 3);
  cloud.confidence.resize(count);
  for (int i = 0; i < count; ++i) {
    cloud.points.row(i).setConstant(i);
    cloud.normals.row(i).setConstant(10 + i);
    cloud.colors.row(i).setConstant(static_cast<std::uint8_t>(20 + i));
    cloud.confidence[i] = static_cast<float>(30 + i);
  }
  return cloud;
}

TEST(KeepRows, KeptPointsKeepTheirAttributesAndTheirOrder) {
  PointCloud cloud = Numbered(5);
  EXPECT_EQ(KeepRows({0, 1, 0, 1, 1}, &cloud), 2);
  ASSERT_EQ(cloud.points.rows(), 3);
  const int expected[3] = {1, 3, 4};
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(cloud.points(i, 2), expected[i]);
    EXPECT_EQ(cloud.normals(i, 0), 10 + expected[i]);
    EXPECT_EQ(cloud.colors(i, 1), 20 + expected[i]);
    EXPECT_EQ(cloud.confidence[i], 30 + expected[i]);
  }
}

TEST(KeepRows, AllOrNone) {
  PointCloud cloud = Numbered(3);
  EXPECT_EQ(KeepRows({1, 1, 1}, &cloud), 0);
  EXPECT_EQ(cloud.points.rows(), 3);
  EXPECT_EQ(KeepRows({0, 0, 0}, &cloud), 3);
  EXPECT_EQ(cloud.points.rows(), 0);
  EXPECT_EQ(cloud.confidence.size(), 0);
}

}  // namespace keypose::reconstruct::cloud_rows_test
