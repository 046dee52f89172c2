#include "core/io/meshes/polygon_mesh.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <vector>

#include "core/io/meshes/mesh_io.h"
#include "core/io/meshes/scan_file.h"
#include "core/io/text/files.h"
#include "core/testing/folder.h"
#include "core/values/errors.h"

namespace keypose::polygon_mesh_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class PolygonFiles : public ::testing::Test, public TestingFolder {
 protected:
  std::filesystem::path Put(const std::string& text) const {
    WriteFile(folder_ / "a.obj", text);
    return folder_ / "a.obj";
  }
};

/// A quad with backward indices, a triangle, a pentagon with a dent, faces that are none.
const std::string kNet =
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf -4/-4 -3/-3 -2/-2 "
    "-1/-1\n"
    "f 1/1 2/2\nv 2 0 0\nv 3 0 0\nv 3 2 0\nv 2.5 0.5 0\nvt 0.5 0.5\nf 2/2 5/1 3/3\n"
    "f 5/1 6/2 7/3 8/5 3/4\n";

TEST_F(PolygonFiles, AreReadWithTheirPolygonsInOrder) {
  const PolygonMesh read = ReadPolygonMesh(Put(kNet));
  EXPECT_THAT(read.polygons.sizes, ElementsAre(4, 3, 5));
  EXPECT_THAT(read.polygons.corners, ElementsAre(0, 1, 2, 3, 1, 4, 2, 4, 5, 6, 7, 2));
  EXPECT_EQ(read.mesh.faces, ReadMesh(folder_ / "a.obj").faces);
  EXPECT_EQ(read.mesh.face_count(), 2 + 1 + 3);
}

TEST_F(PolygonFiles, WithTrianglesAloneHaveNone) {
  EXPECT_THAT(ReadPolygonMesh(Put("v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n")).polygons.sizes,
              IsEmpty());
  WriteMesh(folder_ / "a.ply", ReadMesh(Put(kNet)));
  EXPECT_THAT(ReadPolygonMesh(folder_ / "a.ply").polygons.sizes, IsEmpty());
}

TEST_F(PolygonFiles, AreTheSameWrittenAndReadAgain) {
  const PolygonMesh read = ReadPolygonMesh(Put(kNet));
  WritePolygonObj(folder_ / "b.obj", read, "skin.png");
  EXPECT_THAT(ReadFile(folder_ / "b.obj"), HasSubstr("\nf 5/1 6/2 7/3 8/5 3/4\n"));
  const PolygonMesh again = ReadPolygonMesh(folder_ / "b.obj");
  EXPECT_EQ(again.polygons.sizes, read.polygons.sizes);
  EXPECT_EQ(again.polygons.corners, read.polygons.corners);
  EXPECT_EQ(again.mesh.points, read.mesh.points);
  EXPECT_EQ(again.mesh.faces, read.mesh.faces);
  EXPECT_EQ(again.mesh.uvs, read.mesh.uvs);
  EXPECT_EQ(again.mesh.uv_faces, read.mesh.uv_faces);
}

TEST_F(PolygonFiles, OfAnotherMeshAreNotWritten) {
  PolygonMesh read = ReadPolygonMesh(Put(kNet));
  read.polygons.corners[3] = 7;
  EXPECT_THROW(WritePolygonObj(folder_ / "b.obj", read), InputError);
}

TEST_F(PolygonFiles, ScansHaveThem) {
  EXPECT_THAT(ReadScan(Put(kNet)).polygons.sizes, ElementsAre(4, 3, 5));
  EXPECT_THAT(ReadScanWithoutLook(Put(kNet)).polygons.sizes, ElementsAre(4, 3, 5));
}

/// A quad whose corner 1 lies at the given place, and a triangle beside it. Corner k of the quad
/// has the texture coordinate (k / 4, 0).
std::string QuadWithCornerAt(const std::string& place) {
  return "v 0 0 0\nv " + place +
         " 0\nv 1 1 0\nv 0 1 0\nv 1 2 0\nvt 0.75 0\nvt 0.5 0\nvt 0.25 0\nvt 0 0\n"
         "f 1/4 2/3 3/2 4/1\nf 4/1 3/2 5/4\n";
}

FacesX3 Faces(const std::vector<std::array<int, 3>>& rows) {
  FacesX3 faces(static_cast<Eigen::Index>(rows.size()), 3);
  for (std::size_t f = 0; f < rows.size(); ++f)
    for (int k = 0; k < 3; ++k)
      faces(static_cast<Eigen::Index>(f), k) = rows[f][static_cast<std::size_t>(k)];
  return faces;
}

TEST_F(PolygonFiles, OfOneNetAreCutAsTheFirst) {
  const Mesh flat = ReadMesh(Put(QuadWithCornerAt("1 0")));
  ASSERT_EQ(flat.faces, Faces({{0, 1, 2}, {0, 2, 3}, {3, 2, 4}}));
  const std::filesystem::path path = Put(QuadWithCornerAt("0.25 0.75"));
  const Mesh concave = ReadMesh(path);
  ASSERT_NE(concave.faces.topRows(2), flat.faces.topRows(2)) << "a fan would fold over";
  WriteMesh(folder_ / "first.ply", flat);
  for (const Mesh& first : {flat, ReadMesh(folder_ / "first.ply")}) {
    const Mesh read = ReadMeshCutAs(path, first);
    EXPECT_EQ(read.points, concave.points);
    EXPECT_EQ(read.faces, flat.faces);
    ASSERT_TRUE(read.has_uvs());
    for (int f = 0; f < 2; ++f)
      for (int k = 0; k < 3; ++k)
        EXPECT_EQ(read.uvs(read.uv_faces(f, k), 0), flat.faces(f, k) / 4.0);
    EXPECT_EQ(read.uv_faces.row(2), concave.uv_faces.row(2));
  }
  const Mesh back = ReadMeshCutAs(Put(QuadWithCornerAt("1 0")), concave);
  EXPECT_EQ(back.faces, concave.faces);
  for (int f = 0; f < 2; ++f)
    for (int k = 0; k < 3; ++k)
      EXPECT_EQ(back.uvs(back.uv_faces(f, k), 0), concave.faces(f, k) / 4.0);
}

TEST_F(PolygonFiles, OfAnotherNetKeepTheirTriangles) {
  const std::filesystem::path path = Put(QuadWithCornerAt("0.25 0.75"));
  const Mesh own = ReadMesh(path);
  Mesh first = own;
  for (const FacesX3& faces :
       {Faces({{0, 1, 2}, {0, 2, 4}, {3, 2, 4}}), Faces({{2, 1, 0}, {0, 2, 3}, {3, 2, 4}}),
        Faces({{0, 1, 2}, {0, 2, 3}}), Faces({{0, 1, 2}, {0, 2, 3}, {3, 2, 1}})}) {
    first.faces = faces;
    const Mesh read = ReadMeshCutAs(path, first);
    EXPECT_EQ(read.faces, own.faces);
    EXPECT_EQ(read.uv_faces, own.uv_faces);
  }
}

TEST_F(PolygonFiles, WithAVertexTwiceLoseTheirTextureWhereItIsUnclear) {
  const std::filesystem::path path =
      Put("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 -1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 0.5\nvt 0 1\n"
          "f 1/1 2/2 3/3 1/4 4/5\n");
  const Mesh own = ReadMesh(path);
  Mesh first = own;
  first.faces = Faces({{0, 1, 2}, {2, 0, 3}, {2, 3, 0}});
  ASSERT_NE(own.faces, first.faces);
  const Mesh read = ReadMeshCutAs(path, first);
  EXPECT_EQ(read.faces, first.faces);
  EXPECT_FALSE(read.has_uvs());
  EXPECT_TRUE(ReadMeshCutAs(path, own).has_uvs());
}

}  // namespace keypose::polygon_mesh_test
