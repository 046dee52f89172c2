#include "core/io/meshes/ply_io.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>

#include "core/io/meshes/mesh_io.h"
#include "core/io/testing/damaged_file.h"
#include "core/io/testing/mesh_files.h"
#include "core/io/text/files.h"

namespace keypose::ply_io_test {

namespace fs = std::filesystem;

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

using ::testing::ElementsAre;
using ::testing::HasSubstr;

template <class T>
void PutAs(double number, bool big, std::string* bytes) {
  const T value = static_cast<T>(number);
  std::string at(reinterpret_cast<const char*>(&value), sizeof(T));
  if (big) std::reverse(at.begin(), at.end());
  *bytes += at;
}

void PutTyped(const std::string& type, double number, bool big, std::string* bytes) {
  if (type == "char" || type == "int8") PutAs<std::int8_t>(number, big, bytes);
  if (type == "uchar" || type == "uint8") PutAs<std::uint8_t>(number, big, bytes);
  if (type == "short" || type == "int16") PutAs<std::int16_t>(number, big, bytes);
  if (type == "ushort" || type == "uint16") PutAs<std::uint16_t>(number, big, bytes);
  if (type == "int" || type == "int32") PutAs<std::int32_t>(number, big, bytes);
  if (type == "uint" || type == "uint32") PutAs<std::uint32_t>(number, big, bytes);
  if (type == "float" || type == "float32") PutAs<float>(number, big, bytes);
  if (type == "double" || type == "float64") PutAs<double>(number, big, bytes);
}

/// Each type of the format, as a scalar, a list's length and a list's values, in each encoding.
TEST_F(MeshIo, PlyReadsAllTypesInAllEncodings) {
  for (const std::string format : {"ascii", "binary_little_endian", "binary_big_endian"})
    for (const std::string type :
         {"char", "uchar", "short", "ushort", "int", "uint", "float", "double", "int8", "uint8",
          "int16", "uint16", "int32", "uint32", "float32", "float64"}) {
      const bool real = type[0] == 'f' || type[0] == 'd', big = format == "binary_big_endian";
      const std::string length = real ? "uchar" : type;
      std::string text = "ply\nformat " + format + " 1.0\nelement thing 2\nproperty " + type +
                         " a\nproperty list " + length + " " + type + " b\nend_header\n";
      if (format == "ascii") {
        text += "7 2 1 2\n9 0\n";
      } else {
        for (const auto& [kind, value] :
             {std::pair{type, 7}, {length, 2}, {type, 1}, {type, 2}, {type, 9}, {length, 0}})
          PutTyped(kind, value, big, &text);
      }
      const PlyTable table = ReadPly(Put("a.ply", text));
      EXPECT_THAT(table.at("thing").scalars.at("a"), ElementsAre(7, 9)) << format << type;
      EXPECT_THAT(table.at("thing").lists.at("b").values, ElementsAre(1, 2)) << format << type;
      EXPECT_THAT(table.at("thing").lists.at("b").offsets, ElementsAre(0, 2, 2));
    }
}

TEST_F(MeshIo, PlyTextMayBeOfAnyCaseAndSpreadOverLines) {
  for (const std::string end : {"\n", "\r\n", "\r"}) {
    std::string text;
    for (const char* line :
         {"PLY", "Format ASCII 1.0", "COMMENT made by hand", "obj_info TextureFile My Skin.png",
          "Element Vertex 2", "PROPERTY Float X", "property float y", "end_header", "1", "+2.5 3e0",
          "  -4"})
      text += line + end;
    const fs::path path = Put("a.ply", text);
    const PlyTable table = ReadPly(path);
    EXPECT_THAT(table.at("vertex").scalars.at("x"), ElementsAre(1, 3));
    EXPECT_THAT(table.at("vertex").scalars.at("y"), ElementsAre(2.5, -4));
    EXPECT_THAT(PlyNotes(path, "texturefile"), ElementsAre("My Skin.png"));
  }
}

TEST_F(HostileMesh, PlyHeadersThatAreNotReadAreNamed) {
  const auto message = [&](const std::string& lines) {
    return MeshMessage(Put("a.ply", "ply\n" + lines));
  };
  const std::string format = "format ascii 1.0\n", vertex = "element vertex 1\n";
  EXPECT_THAT(message("format ascii 2.0\n"), HasSubstr("line 2: the version 2.0"));
  EXPECT_THAT(message("format morse 1.0\n"), HasSubstr("'morse' is not known"));
  EXPECT_THAT(message(format + vertex), HasSubstr("no line 'end_header'"));
  EXPECT_THAT(message(vertex + "end_header\n"), HasSubstr("without a line 'format'"));
  EXPECT_THAT(message(format + vertex + "property quad x\n"), HasSubstr("the type 'quad'"));
  EXPECT_THAT(message(format + vertex + "property list float int x\n"), HasSubstr("whole numbers"));
  EXPECT_THAT(message(format + "property float x\n"), HasSubstr("before any element"));
  EXPECT_THAT(message(format + vertex + vertex), HasSubstr("two elements 'vertex'"));
  EXPECT_THAT(message(format + vertex + "property float x\nproperty float X\n"),
              HasSubstr("two properties 'x'"));
  EXPECT_THAT(message(format + "elements vertex 1\n"), HasSubstr("no line of a PLY header"));
}

TEST_F(HostileMesh, PlyDataThatDoNotFitTheirHeaderAreNamed) {
  const auto message = [&](const std::string& rest) {
    return MeshMessage(Put("a.ply",
                           "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\n"
                           "property list char int n\nend_header\n" +
                               rest));
  };
  EXPECT_THAT(message("1 0\n2"), HasSubstr("ends at 'vertex' 1 of 2; it is truncated"));
  EXPECT_THAT(message("1 0\n2 0\n3\n"), HasSubstr("line 9: '3' comes after all"));
  EXPECT_THAT(message("1 -1\n2 0\n"), HasSubstr("claims -1 values"));
  EXPECT_THAT(message("1 1.5\n2 0\n"), HasSubstr("claims 1.5 values"));
  EXPECT_THAT(message("1 0\n2x 0\n"), HasSubstr("line 8: '2x' of 'vertex' 1 is no number"));
}

}  // namespace keypose::ply_io_test
