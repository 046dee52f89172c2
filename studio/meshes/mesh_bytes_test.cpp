#include "studio/meshes/mesh_bytes.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>

#include "core/surfaces/shapes.h"

namespace keypose::studio::mesh_bytes_test {

template <class T>
T At(const std::string& bytes, std::size_t offset) {
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

TEST(MeshBytes, HasHeadPositionsIndicesAndColours) {
  Mesh mesh = MakeBox(1, 2, 3);
  mesh.colors.resize(8, 3);
  mesh.colors.setConstant(7);
  const std::string bytes = MeshBytes(mesh);
  ASSERT_EQ(bytes.size(), 16u + 8 * 12 + 12 * 12 + 8 * 4);
  EXPECT_EQ(bytes.substr(0, 4), "KPM1");
  EXPECT_EQ(At<std::uint32_t>(bytes, 4), 8u);
  EXPECT_EQ(At<std::uint32_t>(bytes, 8), 12u);
  EXPECT_EQ(At<std::uint32_t>(bytes, 12), 2u);
  EXPECT_EQ(At<float>(bytes, 16 + 4 * (3 * 5 + 2)), static_cast<float>(mesh.points(5, 2)));
  EXPECT_EQ(At<std::uint32_t>(bytes, 16 + 96 + 4 * (3 * 11 + 1)),
            static_cast<std::uint32_t>(mesh.faces(11, 1)));
  EXPECT_EQ(bytes.substr(bytes.size() - 4), std::string("\x07\x07\x07\x00", 4));
}

TEST(CloudBytes, ShowsAtMostSoManyPointsSpreadEvenly) {
  PointCloud cloud;
  cloud.points.resize(100, 3);
  for (int i = 0; i < 100; ++i) cloud.points.row(i).setConstant(i);
  const std::string bytes = CloudBytes(cloud, 10);
  EXPECT_EQ(At<std::uint32_t>(bytes, 4), 10u);
  EXPECT_EQ(At<std::uint32_t>(bytes, 8), 0u);
  for (int k = 0; k < 10; ++k) EXPECT_EQ(At<float>(bytes, 16 + 12 * k), 10.f * k);
  EXPECT_EQ(At<std::uint32_t>(CloudBytes(cloud, 1000), 4), 100u);
}

TEST(FitBytes, AreDistancesOverTheScansDiagonal) {
  const Mesh scan = MakeBox(2, 2, 2);
  Mesh mesh = scan;
  mesh.points.row(7) *= 1.5;  // the corner off the origin
  const std::string bytes = FitBytes(mesh, scan);
  ASSERT_EQ(bytes.size(), 32u);
  EXPECT_NEAR(At<float>(bytes, 28), 0.5, 1e-6);
  EXPECT_NEAR(At<float>(bytes, 0), 0, 1e-6);
}

}  // namespace keypose::studio::mesh_bytes_test
