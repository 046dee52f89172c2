#include "core/io/meshes/ply_mesh.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>

#include "core/io/meshes/mesh_io.h"
#include "core/io/testing/damaged_file.h"
#include "core/io/testing/mesh_files.h"

namespace keypose::ply_mesh_test {

namespace fs = std::filesystem;

TEST_F(HostileMesh, PlyFaceCornersThatAreNoVertexThrow) {
  const std::string head =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float "
      "z\n"
      "element face 1\nproperty list uchar float vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n";
  EXPECT_EQ(ReadMesh(Put("good.ply", head + "3 0 1 2\n")).face_count(), 1);
  for (const char* face : {"3 0 1 nan\n", "3 0 1 1e30\n", "3 0 1 -1\n", "3 0 1 clay\n"})
    MeshMessage(Put("bad.ply", head + face));
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

using ::testing::HasSubstr;

/// A triangle whose vertices have three more columns.
std::string WithColors(const std::string& type, const std::array<const char*, 3>& names,
                       const std::string& first) {
  std::string text =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
      "property float z\n";
  for (const char* name : names) text += "property " + type + " " + name + "\n";
  return text + "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0 " +
         first + "\n1 0 0 0 0 0\n0 1 0 0 0 0\n3 0 1 2\n";
}

TEST_F(MeshIo, PlyColorsAreReadByTypeAndValue) {
  constexpr std::array<const char*, 3> kUsual = {"red", "green", "blue"};
  const auto color = [&](const std::string& type, const std::string& first,
                         const std::array<const char*, 3>& names) {
    const Mesh mesh = ReadMesh(Put("m.ply", WithColors(type, names, first)));
    return mesh.colors.rows() == 0 ? Eigen::RowVector3i(-1, -1, -1)
                                   : Eigen::RowVector3i(mesh.colors.row(0).cast<int>());
  };
  const Eigen::RowVector3i right(255, 51, 0);
  for (const char* type : {"uchar", "short", "ushort", "int", "uint", "float", "double"})
    EXPECT_EQ(color(type, "255 51 0", kUsual), right) << type;
  EXPECT_EQ(color("char", "-1 51 0", kUsual), right);
  for (const char* type : {"ushort", "int", "uint", "float", "double"})
    EXPECT_EQ(color(type, "65535 13107 0", kUsual), right) << type;
  for (const char* type : {"float", "double"})
    EXPECT_EQ(color(type, "1 0.2 0", kUsual), right) << type;
  for (const std::array<const char*, 3>& names :
       {std::array{"diffuse_red", "diffuse_green", "diffuse_blue"}, std::array{"r", "g", "b"},
        std::array{"RED", "Green", "blue"}})
    EXPECT_EQ(color("uchar", "255 51 0", names), right) << names[0];
  EXPECT_EQ(color("float", "1 0 0", {"nx", "ny", "nz"}), Eigen::RowVector3i(-1, -1, -1));
}

TEST_F(MeshIo, ColorsOfPlyFacesBecomeThoseOfTheirVertices) {
  const Mesh mesh =
      ReadMesh(Put("m.ply",
                   "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
                   "property float z\nelement face 2\nproperty list uchar int vertex_indices\n"
                   "property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n"
                   "0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2 200 0 0\n3 0 2 3 0 100 0\n"));
  ASSERT_EQ(mesh.colors.rows(), 4);
  EXPECT_EQ(mesh.colors.row(0).cast<int>(), Eigen::RowVector3i(100, 50, 0));
  EXPECT_EQ(mesh.colors.row(1).cast<int>(), Eigen::RowVector3i(200, 0, 0));
}

const char* const kFourVertices =
    "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
    "property float z\n";
const char* const kFourPlaces = "end_header\n0 0 5\n1 0 5\n0 1 5\n1 1 5\n";

TEST_F(MeshIo, StripsOfTrianglesOfAPlyAreRead) {
  const auto read = [&](const std::string& strip) {
    return ReadMesh(Put("m.ply", std::string(kFourVertices) +
                                     "element tristrips 1\nproperty list int int vertex_indices\n" +
                                     kFourPlaces + strip));
  };
  const Mesh one = read("4 0 1 2 3\n");
  ASSERT_EQ(one.face_count(), 2);
  EXPECT_EQ(one.faces.row(0), Eigen::RowVector3i(0, 1, 2));
  EXPECT_EQ(one.faces.row(1), Eigen::RowVector3i(2, 1, 3));
  const Mesh two = read("8 0 1 2 -1 2 1 3 -1\n");
  ASSERT_EQ(two.face_count(), 2);
  EXPECT_EQ(two.faces.row(1), Eigen::RowVector3i(2, 1, 3));
  EXPECT_EQ(read("6 0 1 2 2 3 3\n").face_count(), 1) << "thin ones only join strips";
}

TEST_F(HostileMesh, PlyKindsThatHoldNoPolygonsAreNamed) {
  const auto message = [&](const std::string& elements, const std::string& rows) {
    return MeshMessage(Put("m.ply", kFourVertices + elements + kFourPlaces + rows));
  };
  EXPECT_THAT(message("element range_grid 1\nproperty list uchar int vertex_indices\n", "1 0\n"),
              HasSubstr("a range grid"));
  EXPECT_THAT(message("element multi_texture_face 1\nproperty uchar tx\n", "1\n"),
              HasSubstr("multi_texture_face"));
  EXPECT_THAT(message("element face 1\nproperty list uchar int corners\n", "3 0 1 2\n"),
              HasSubstr("faces without a list vertex_indices"));
  EXPECT_THAT(message("element tristrips 1\nproperty int length\n", "3\n"),
              HasSubstr("tristrips without a list"));
  EXPECT_THAT(message("element face 1\nproperty list uchar int vertex_indices\n"
                      "property list uchar float texcoord\n",
                      "3 0 1 2 4 0 0 1 0\n"),
              HasSubstr("has 4 numbers in the list texcoord of face 0"));
  EXPECT_THAT(MeshMessage(Put("m.ply",
                              "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\n"
                              "property float y\nproperty float z\nproperty float f_dc_0\n"
                              "property float scale_0\nproperty float rot_0\nend_header\n"
                              "0 0 0 1 1 1\n")),
              HasSubstr("Gaussian splats"));
}

TEST_F(MeshIo, TextureCoordinatesOfPlyVerticesByOtherNames) {
  for (const auto& [u, v] :
       {std::pair{"u", "v"}, {"S", "T"}, {"texture_s", "texture_t"}, {"s0", "t0"}, {"u0", "v0"}})
    ExpectUvsAreThePlaces(ReadMesh(
        Put("m.ply", std::string("ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\n"
                                 "property float y\nproperty float z\nproperty float ") +
                         u + "\nproperty double " + v + "\n" + kSquareFace +
                         "end_header\n0 0 5 0 0\n1 0 5 1 0\n1 1 5 1 1\n0 1 5 0 1\n4 0 1 2 3\n")));
}

TEST_F(MeshIo, PackedColorsOfPlyAreRead) {
  const auto color = [&](const std::string& property, const std::string& value,
                         const char* format = "ascii") {
    const std::string head = std::string("ply\nformat ") + format +
                             " 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
                             "property float z\nproperty " +
                             property + "\nend_header\n";
    const bool text = std::string(format) == "ascii";
    const Mesh mesh =
        ReadMesh(Put("m.ply", head + (text ? "0 0 0 " : std::string(12, '\0')) + value));
    return mesh.colors.rows() == 0 ? Eigen::RowVector3i(-1, -1, -1)
                                   : Eigen::RowVector3i(mesh.colors.row(0).cast<int>());
  };
  const Eigen::RowVector3i right(255, 51, 16);
  EXPECT_EQ(color("uint rgb", "16724752\n"), right);
  EXPECT_EQ(color("int rgb", "16724752\n"), right);
  EXPECT_EQ(color("uint rgba", "4294914832\n"), right) << "alpha lies above red";
  EXPECT_EQ(color("int rgba", "-52464\n"), right);
  const std::string bits("\x10\x33\xff\x00", 4), opaque("\x10\x33\xff\xff", 4),
      quiet("\x10\x33\xbf\xff", 4);
  for (const char* property : {"float rgb", "uint rgb", "float rgba", "uint rgba"}) {
    EXPECT_EQ(color(property, bits, "binary_little_endian"), right) << property;
    EXPECT_EQ(color(property, opaque, "binary_little_endian"), right) << property;
    // As a number it would be a NaN that signals, which arithmetic makes a quiet one.
    EXPECT_EQ(color(property, quiet, "binary_little_endian"), Eigen::RowVector3i(191, 51, 16));
    EXPECT_EQ(color(property, std::string(opaque.rbegin(), opaque.rend()), "binary_big_endian"),
              right);
  }
  EXPECT_EQ(color("float rgb", "2.34363693e-38\n"), right) << "its bits are 00ff3310";
  EXPECT_EQ(color("float rgb", "16724752\n"), right);
  EXPECT_EQ(color("float rgb", "nan\n"), Eigen::RowVector3i(-1, -1, -1));
  EXPECT_THAT(ReadPlyPages(folder_ / "m.ply").notes, ::testing::ElementsAre(HasSubstr("'rgb'")));
}

TEST_F(MeshIo, BrightnessOfAPlyIsNamedWhereItHasNoColors) {
  const std::string head =
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
      "property float z\nproperty float intensity\n";
  const PlyPages grey = ReadPlyPages(Put("m.ply", head + "end_header\n0 0 0 0.5\n"));
  EXPECT_EQ(grey.mesh.colors.rows(), 0);
  EXPECT_THAT(
      grey.notes,
      ::testing::ElementsAre("it has no colours that are read; 'intensity' of its vertices is left "
                             "out"));
  const std::string colors = "property uchar red\nproperty uchar green\nproperty uchar blue\n";
  EXPECT_THAT(ReadPlyPages(Put("m.ply", head + colors + "end_header\n0 0 0 0.5 1 2 3\n")).notes,
              ::testing::IsEmpty());
  EXPECT_EQ(ReadMesh(Put("m.ply", "\xef\xbb\xbf" + head + "end_header\n7 0 0 0.5\n")).points(0, 0),
            7)
      << "a byte order mark";
}

}  // namespace keypose::ply_mesh_test
