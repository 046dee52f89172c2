#include <gtest/gtest.h>

#include "core/errors.h"
#include "core/geometry.h"
#include "core/io/files.h"
#include "core/io/mesh_io.h"
#include "core/io/testing_folder.h"
#include "core/testing_shapes.h"

namespace keypose {
namespace {

Mesh ColoredSphereWithUvs() {
  Mesh mesh = MakeIcosphere(2);
  mesh.normals = VertexNormals(mesh.points, mesh.faces);
  mesh.colors = ColorsX3::Constant(mesh.points.rows(), 3, 77);
  mesh.uvs = (mesh.points.leftCols(2).array() * 0.5 + 0.5).matrix();
  mesh.uv_faces = mesh.faces;
  return mesh;
}

class MeshIo : public testing::Test, public TestingFolder {};

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

TEST_F(MeshIo, ObjKeepsPositionsUvsAndNamesItsMaterial) {
  const Mesh mesh = ColoredSphereWithUvs();
  WriteMesh(folder_ / "m.obj", mesh, "texture.png");
  const Mesh read = ReadMesh(folder_ / "m.obj");
  // The OBJ parser rounds decimals itself and may miss the last bits.
  EXPECT_LT((read.points - mesh.points).cwiseAbs().maxCoeff(), 1e-14);
  EXPECT_EQ(read.faces, mesh.faces);
  EXPECT_EQ(read.uv_faces, mesh.uv_faces);
  EXPECT_LT((read.uvs - mesh.uvs).cwiseAbs().maxCoeff(), 1e-14);
  EXPECT_NE(ReadFile(folder_ / "m.mtl").find("map_Kd texture.png"), std::string::npos);
}

TEST_F(MeshIo, FormatIsToldByContentNotByName) {
  WriteMesh(folder_ / "m.ply", MakeIcosphere(1));
  fs::rename(folder_ / "m.ply", folder_ / "m.obj");
  EXPECT_EQ(ReadMesh(folder_ / "m.obj").face_count(), 80);
}

TEST_F(MeshIo, ReadsQuadsNegativeIndicesOffAndStl) {
  EXPECT_EQ(
      ReadMesh(Put("q.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf -4 -3 -2 -1\n")).face_count(),
      2);
  EXPECT_EQ(ReadMesh(Put("t.off", "OFF\n# a comment\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"))
                .face_count(),
            1);
  const Mesh stl = ReadMesh(Put("t.stl",
                                "solid t\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 "
                                "0\nvertex 0 1 0\nendloop\nendfacet\nendsolid t\n"));
  EXPECT_EQ(stl.face_count(), 1);
  EXPECT_EQ(stl.vertex_count(), 3);
}

TEST_F(MeshIo, DamagedFilesThrowInputErrorWithThePath) {
  WriteMesh(folder_ / "whole.ply", MakeIcosphere(2));
  const std::string bytes = ReadFile(folder_ / "whole.ply");
  for (const auto& path : {Put("cut.ply", bytes.substr(0, bytes.size() / 2)),
                           Put("index.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n"),
                           Put("noise.bin", "\x01\x02\x03 nothing"), Put("empty.ply", ""),
                           Put("cut.off", "OFF\n3 1 0\n0 0 0\n")}) {
    try {
      ReadMesh(path);
      ADD_FAILURE() << path << " was read";
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(path.filename().string()), std::string::npos)
          << error.what();
    }
  }
  EXPECT_THROW(ReadMesh(folder_ / "absent.ply"), DiskError);
}

TEST_F(MeshIo, ObjLinesContinuedWithABackslashAreRead) {
  const std::string plain = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";
  const std::string folded = "v 0 \\\n0 0\nv 1 0 0\nv 1 1 \\\r\n 0\nv 0 1 0\nf 1 2 \\\n 3 \\\n 4\n";
  const Mesh expected = ReadMesh(Put("plain.obj", plain)),
             read = ReadMesh(Put("folded.obj", folded));
  EXPECT_EQ(read.points, expected.points);
  EXPECT_EQ(read.faces, expected.faces);
  EXPECT_EQ(read.faces.rows(), 2);
}

TEST_F(MeshIo, ObjVertexBelowAContinuedLineThrowsWithItsOwnLine) {
  const fs::path path = Put("bad.obj", "v 0 \\\n0 0\nv 1 0 0\nv 1 nan 0\nf 1 2 3\n");
  try {
    ReadMesh(path);
    FAIL() << "nan was read";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("bad.obj:4:"), std::string::npos) << error.what();
  }
}

TEST_F(MeshIo, ObjVertexThatIsNoNumberThrowsWithItsLine) {
  for (const char* bad : {"nan", "inf", "clay"}) {
    try {
      ReadMesh(Put("bad.obj", std::string("v 0 0 0\nv 1 0 0\nv 0 1 ") + bad + "\nf 1 2 3\n"));
      ADD_FAILURE() << bad << " was read";
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find("bad.obj:3"), std::string::npos) << error.what();
    }
  }
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

}  // namespace
}  // namespace keypose
