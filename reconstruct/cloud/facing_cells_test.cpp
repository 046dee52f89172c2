#include "reconstruct/cloud/facing_cells.h"

#include <gtest/gtest.h>

#include <random>

#include "core/numbers/parallel.h"

namespace keypose::reconstruct::facing_cells_test {

PointCloud Scattered(int count) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(-1, 1);
  PointCloud cloud;
  cloud.points.resize(count, 3);
  cloud.normals.resize(count, 3);
  for (int i = 0; i < count; ++i)
    for (int c = 0; c < 3; ++c) {
      cloud.points(i, c) = unit(random);
      cloud.normals(i, c) = unit(random);
    }
  return cloud;
}

TEST(SortByFacingCell, PointsOfOneKeyShareTheirCellAndTheirOctant) {
  constexpr double kCell = 0.25;
  const PointCloud cloud = Scattered(3000);
  const std::vector<KeyedPoint> keyed = SortByFacingCell(cloud, kCell);
  ASSERT_EQ(keyed.size(), 3000u);
  int shared = 0;
  for (std::size_t k = 1; k < keyed.size(); ++k) {
    ASSERT_LE(keyed[k - 1].key, keyed[k].key);
    if (keyed[k - 1].key != keyed[k].key) continue;
    ++shared;
    ASSERT_LT(keyed[k - 1].point, keyed[k].point);
    for (int c = 0; c < 3; ++c) {
      EXPECT_LT(std::abs(cloud.points(keyed[k].point, c) - cloud.points(keyed[k - 1].point, c)),
                kCell);
      EXPECT_EQ(cloud.normals(keyed[k].point, c) > 0, cloud.normals(keyed[k - 1].point, c) > 0);
    }
  }
  EXPECT_GT(shared, 100);
}

TEST(SortByFacingCell, SameOrderForAnyThreadCount) {
  const PointCloud cloud = Scattered(20000);
  SetThreadCount(1);
  const std::vector<KeyedPoint> one = SortByFacingCell(cloud, 0.1);
  SetThreadCount(3);
  const std::vector<KeyedPoint> three = SortByFacingCell(cloud, 0.1);
  SetThreadCount(0);
  for (std::size_t k = 0; k < one.size(); ++k) ASSERT_EQ(one[k].point, three[k].point);
}

}  // namespace keypose::reconstruct::facing_cells_test
