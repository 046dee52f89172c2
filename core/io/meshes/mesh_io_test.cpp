#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/io/meshes/mesh_io.h"
#include "core/io/meshes/mesh_look.h"
#include "core/io/text/files.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/shapes.h"
#include "core/testing/folder.h"
#include "core/values/errors.h"

namespace keypose::mesh_io_test {

Mesh ColoredSphereWithUvs() {
  Mesh mesh = MakeIcosphere(2);
  mesh.normals = VertexNormals(mesh.points, mesh.faces);
  mesh.colors = ColorsX3::Constant(mesh.points.rows(), 3, 77);
  mesh.uvs = (mesh.points.leftCols(2).array() * 0.5 + 0.5).matrix();
  mesh.uv_faces = mesh.faces;
  return mesh;
}

class MeshIo : public ::testing::Test, public TestingFolder {};

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

/// Both triangles of a unit square whose texture coordinates are its places.
void ExpectUvsAreThePlaces(const Mesh& mesh) {
  ASSERT_EQ(mesh.face_count(), 2);
  ASSERT_TRUE(mesh.has_uvs());
  for (int f = 0; f < 2; ++f)
    for (int k = 0; k < 3; ++k)
      EXPECT_EQ(mesh.uvs.row(mesh.uv_faces(f, k)), mesh.points.row(mesh.faces(f, k)).head(2));
}

const char* const kSquareFace = "element face 1\nproperty list uchar int vertex_indices\n";

TEST_F(MeshIo, TextureCoordinatesOfPlyVerticesAreReadAsBlenderAndMeshLabWriteThem) {
  for (const auto& [u, v] : {std::pair{"s", "t"}, {"texture_u", "texture_v"}})
    ExpectUvsAreThePlaces(ReadMesh(
        Put("m.ply", std::string("ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\n"
                                 "property float y\nproperty float z\nproperty float ") +
                         u + "\nproperty float " + v + "\n" + kSquareFace +
                         "end_header\n0 0 5 0 0\n1 0 5 1 0\n1 1 5 1 1\n0 1 5 0 1\n4 0 1 2 3\n")));
}

TEST_F(MeshIo, QuadsOfAPlyKeepTheTextureCoordinatesOfTheirCorners) {
  ExpectUvsAreThePlaces(ReadMesh(
      Put("m.ply", std::string("ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\n"
                               "property float y\nproperty float z\n") +
                       kSquareFace +
                       "property list uchar float texcoord\nend_header\n"
                       "0 0 5\n1 0 5\n1 1 5\n0 1 5\n4 0 1 2 3 8 0 0 1 0 1 1 0 1\n")));
}

TEST_F(MeshIo, AnObjFaceWithoutTextureCoordinatesDoesNotTakeThoseOfOthers) {
  const std::string square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0.5 0.5\nvt 1 0\nvt 1 1\n";
  const Mesh mesh = ReadMesh(Put("m.obj", square + "f 1/1 2/2 3/3\nf 1 3 4\n"));
  ASSERT_TRUE(mesh.has_uvs());
  EXPECT_EQ(mesh.uvs.row(mesh.uv_faces(0, 0)), Eigen::RowVector2d(0.5, 0.5));
  for (int k = 0; k < 3; ++k)
    EXPECT_EQ(mesh.uvs.row(mesh.uv_faces(1, k)), Eigen::RowVector2d(0, 0));
  EXPECT_FALSE(ReadMesh(Put("m.obj", square + "f 1 2 3\nf 1 3 4\n")).has_uvs());
  EXPECT_THROW(ReadMesh(Put("m.obj", square + "f 1/9 2/2 3/3\nf 1 3 4\n")), InputError);
}

TEST_F(MeshIo, ObjKeepsColoursOfItsVertices) {
  const ColorsX3 expected = (ColorsX3(3, 3) << 255, 0, 51, 0, 255, 0, 0, 0, 255).finished();
  EXPECT_EQ(
      ReadMesh(Put("m.obj", "v 0 0 0 1 0 0.2\nv 1 0 0 0 1.0 0\nv 0 1 0 0 0 1\nf 1 2 3\n")).colors,
      expected);
  EXPECT_EQ(ReadMesh(Put("m.obj",
                         "v 0 0 0 255 0 51\r\nv 1 0 0 0 255 0\r\nv 0 1 0 0 0 255\r\nf 1 2 3\r\n"))
                .colors,
            expected);
  EXPECT_EQ(ReadMesh(Put("m.obj", "v 0 0 0 1\nv 1 0 0 1\nv 0 1 0 1\nf 1 2 3\n")).colors.rows(), 0)
      << "a fourth coordinate is no colour";
}

TEST_F(MeshIo, AnObjWhoseFirstObjectIsACoffeeCupIsNoOff) {
  for (const std::string first : {"o Coffee_cup", "g office", "s off"})
    EXPECT_EQ(ReadMesh(Put("m.obj", first + "\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")).face_count(),
              1)
        << first;
}

TEST_F(MeshIo, MeshesOfFormatsThatAreNotReadAreCalledWhatTheyAre) {
  for (const auto& [head, kind] : {std::pair<std::string, const char*>{"glTF\x02", "glTF"},
                                   {"Kaydara FBX Binary  ", "FBX"},
                                   {"#usda 1.0\n(\n", "USD"},
                                   {"<?xml version=\"1.0\"?><COLLADA/>", "Collada"},
                                   {"{\"asset\": {\"version\": \"2.0\"}}", "glTF"}})
    try {
      ReadMesh(Put("m.bin", head));
      ADD_FAILURE() << kind << " was read";
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(),
                  ::testing::AllOf(::testing::HasSubstr(kind), ::testing::HasSubstr("export it as OBJ")));
    }
}

TEST_F(MeshIo, WhatOneMaterialWithOneTextureCannotShowIsSaid) {
  const std::string square =
      "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 1.5 1\n";
  const auto warnings = [&](const std::string& faces) {
    const fs::path path = Put("two parts.obj", square + faces);
    return LookWarnings(path, ReadMesh(path));
  };
  EXPECT_THAT(warnings("usemtl skin\nf 1/1 2/2 3/3\nf 1/1 3/3 4/2\nusemtl unused\n"),
              ::testing::IsEmpty());
  EXPECT_THAT(warnings("usemtl skin\nf 1/1 2/2 3/3\nusemtl red cloth\r\nf 1/1 3/3 4/2\n"),
              ::testing::ElementsAre(::testing::HasSubstr("2 materials (red cloth, skin)")));
  EXPECT_THAT(
      warnings("f 1/1 2/2 3/4\nf 1/1 3/3 4/2\n"),
      ::testing::ElementsAre(::testing::HasSubstr("1 of 2 faces of two parts.obj lie outside")));
  EXPECT_THAT(warnings("f 1/1 2/2 3/3\nf 1 3 4\n"),
              ::testing::ElementsAre(::testing::HasSubstr("1 of 2 faces")));
  EXPECT_THAT(warnings("f 1 2 3\nusemtl cloth\nf 1 3 4\n"), ::testing::IsEmpty());
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

}  // namespace keypose::mesh_io_test
