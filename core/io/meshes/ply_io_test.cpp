#include "core/io/meshes/ply_io.h"

#include <gtest/gtest.h>

#include "core/io/meshes/mesh_io.h"
#include "core/io/testing/mesh_files.h"

namespace keypose::ply_io_test {

TEST_F(MeshIo, PlyKeepsEveryBitAndTheUvs) {
  const Mesh mesh = ColoredSphereWithUvs();
  WriteMesh(folder_ / "m.ply", mesh);
  const Mesh read = ReadMesh(folder_ / "m.ply");
  EXPECT_EQ(read.points, mesh.points);
  EXPECT_EQ(read.faces, mesh.faces);
  EXPECT_EQ(read.colors, mesh.colors);
  EXPECT_LT((read.normals - mesh.normals).norm(), 1e-5);
  ASSERT_TRUE(read.has_uvs());
  for (Eigen::Index f = 0; f < mesh.faces.rows(); ++f)
    for (int k = 0; k < 3; ++k)
      EXPECT_EQ(read.uvs.row(read.uv_faces(f, k)), mesh.uvs.row(mesh.uv_faces(f, k)));
}

TEST_F(MeshIo, CloudKeepsConfidence) {
  PointCloud cloud;
  cloud.points = PointsX3::Random(10, 3);
  cloud.normals = cloud.points.rowwise().normalized();
  cloud.confidence = Eigen::VectorXf::LinSpaced(10, 0, 1);
  WritePointCloud(folder_ / "c.ply", cloud);
  const PointCloud read = ReadPointCloud(folder_ / "c.ply");
  EXPECT_EQ(read.points, cloud.points);
  EXPECT_EQ(read.confidence, cloud.confidence);
}

}  // namespace keypose::ply_io_test
