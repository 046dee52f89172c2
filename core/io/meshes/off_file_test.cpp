// Each part of Geomview's OFF is read with these numbers, or refused by name.
#include "core/io/meshes/off_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

#include "core/io/meshes/face_colors.h"
#include "core/io/meshes/mesh_io.h"
#include "core/io/meshes/scan_file.h"
#include "core/io/testing/damaged_file.h"

namespace keypose::off_file_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class OffFile : public HostileFile {
 protected:
  NotedMesh Read(const std::string& text) const {
    const fs::path path = Put("a.off", text);
    EXPECT_EQ(MeshKindOf(path), MeshKind::kOff) << text;
    return ReadOff(path);
  }
  Mesh Plain(const std::string& text) const {
    NotedMesh noted = Read(text);
    EXPECT_THAT(noted.notes, IsEmpty()) << text;
    return std::move(noted.mesh);
  }
  std::string Refusal(const std::string& text) const { return MeshMessage(Put("a.off", text)); }
};

/// A triangle: what stands behind each vertex, and behind the face.
std::string Triangle(const std::string& keyword, const std::string& a, const std::string& b,
                     const std::string& c, const std::string& face = "") {
  return keyword + "\n3 1 0\n0 0 0 " + a + "\n2 0 0 " + b + "\n0 4 0 " + c + "\n3 0 1 2 " + face +
         "\n";
}

Eigen::RowVector3i ColorOf(const Mesh& mesh, int vertex) {
  if (mesh.colors.rows() <= vertex) return {-1, -1, -1};
  return mesh.colors.row(vertex).cast<int>();
}

void ExpectTriangle(const Mesh& mesh) {
  ASSERT_EQ(mesh.points.rows(), 3);
  EXPECT_EQ(mesh.points.row(1), Eigen::RowVector3d(2, 0, 0));
  EXPECT_EQ(mesh.points.row(2), Eigen::RowVector3d(0, 4, 0));
  ASSERT_EQ(mesh.faces.rows(), 1);
  EXPECT_EQ(mesh.faces.row(0), Eigen::RowVector3i(0, 1, 2));
}

TEST_F(OffFile, ColorsOfVertices) {
  const auto second = [&](const std::string& color) {
    const Mesh mesh = Plain(Triangle("COFF", "0 0 0", color, "0 0 0"));
    ExpectTriangle(mesh);
    return ColorOf(mesh, 1);
  };
  EXPECT_EQ(second("255 51 0"), Eigen::RowVector3i(255, 51, 0));
  EXPECT_EQ(second("255 51 0 128"), Eigen::RowVector3i(255, 51, 0));
  EXPECT_EQ(second("1.0 0.2 0.0"), Eigen::RowVector3i(255, 51, 0));
  EXPECT_EQ(second("1.0 0.2 0.0 1.0"), Eigen::RowVector3i(255, 51, 0));
  EXPECT_EQ(second("255.0 51.0 0.0"), Eigen::RowVector3i(255, 51, 0));
  // A level of 1 beside one of 200, and the fraction 1.
  EXPECT_EQ(ColorOf(Plain(Triangle("COFF", "200 0 0", "1 0 0", "0 0 0")), 1),
            Eigen::RowVector3i(1, 0, 0));
  EXPECT_EQ(ColorOf(Plain(Triangle("COFF", "0.5 0 0", "1 0 0", "0 0 0")), 1),
            Eigen::RowVector3i(255, 0, 0));
  // One without a colour takes its neighbours'.
  EXPECT_EQ(ColorOf(Plain(Triangle("COFF", "9 9 9", "", "9 9 9")), 1), Eigen::RowVector3i(9, 9, 9));
}

TEST_F(OffFile, ColorsOfFaces) {
  for (const char* color : {"255 51 0", "255 51 0 255", "1.0 0.2 0.0", "1.0 0.2 0.0 0.5"})
    for (int v = 0; v < 3; ++v)
      EXPECT_EQ(ColorOf(Plain(Triangle("OFF", "", "", "", color)), v),
                Eigen::RowVector3i(255, 51, 0))
          << color;
  const std::string square = "OFF\n4 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n";
  const NotedMesh two = Read(square + "3 0 1 2 200 0 0 # red\n3 0 2 3 0 100 0\n");
  EXPECT_EQ(ColorOf(two.mesh, 0), Eigen::RowVector3i(100, 50, 0));
  EXPECT_EQ(ColorOf(two.mesh, 1), Eigen::RowVector3i(200, 0, 0));
  EXPECT_THAT(two.notes, ElementsAre(kColorsBlend));
  const Scan scan = ReadScan(folder_ / "a.off");
  EXPECT_THAT(scan.warnings, ElementsAre(HasSubstr("blend where faces of different colours meet")));
  EXPECT_EQ(scan.mesh.colors, two.mesh.colors);
  // Vertices come first.
  EXPECT_EQ(ColorOf(Plain(Triangle("COFF", "9 9 9", "9 9 9", "9 9 9", "255 0 0")), 0),
            Eigen::RowVector3i(9, 9, 9));
  const NotedMesh mapped = Read(square + "3 0 1 2 7\n3 0 2 3 8\n");
  EXPECT_EQ(mapped.mesh.colors.rows(), 0);
  EXPECT_THAT(mapped.notes, ElementsAre(HasSubstr("colour map")));
}

TEST_F(OffFile, EachPrefix) {
  const Mesh normal = Plain(Triangle("NOFF", "0 0 1", "0 0 1", "0 0 1"));
  ExpectTriangle(normal);
  ASSERT_EQ(normal.normals.rows(), 3);
  EXPECT_EQ(normal.normals.row(1), Eigen::RowVector3d(0, 0, 1));
  const Mesh uvs = Plain(Triangle("STOFF", "0 0", "0.5 0.25", "0 1"));
  ExpectTriangle(uvs);
  ASSERT_TRUE(uvs.has_uvs());
  EXPECT_EQ(uvs.uvs.row(uvs.uv_faces(0, 1)), Eigen::RowVector2d(0.5, 0.25));
  const Mesh all =
      Plain(Triangle("STCNOFF", "0 0 1 9 8 7 0 0", "0 0 1 9 8 7 255 0.5 0.25", "0 0 1 9 8 7 0 1"));
  ExpectTriangle(all);
  EXPECT_EQ(all.normals.row(1), Eigen::RowVector3d(0, 0, 1));
  EXPECT_EQ(ColorOf(all, 1), Eigen::RowVector3i(9, 8, 7));
  EXPECT_EQ(all.uvs.row(1), Eigen::RowVector2d(0.5, 0.25));
  ExpectTriangle(Plain("4OFF\n3 1 0\n0 0 0 1\n4 0 0 2\n0 2 0 0.5\n3 0 1 2\n"));
  ExpectTriangle(Plain("nOFF\n3\n3 1 0\n0 0 0\n2 0 0\n0 4 0\n3 0 1 2\n"));
  ExpectTriangle(Plain("4nOFF 3 3 1 0\n0 0 0 1\n2 0 0 1\n0 4 0 1\n3 0 1 2\n"));
  EXPECT_THAT(Refusal("nOFF\n4\n3 1 0\n0 0 0 1\n2 0 0 1\n0 4 0 1\n3 0 1 2\n"),
              HasSubstr("have 4 dimensions"));
  EXPECT_THAT(Refusal("4OFF\n3 1 0\n0 0 0 1\n2 0 0 0\n0 4 0 1\n3 0 1 2\n"),
              HasSubstr("vertex 1 lies at infinity"));
}

TEST_F(OffFile, TextAsItIsFound) {
  const std::string body = "0 0 0\n2 0 0\n0 4 0\n3 0 1 2\n";
  for (const std::string head :
       {"OFF\n3 1 0\n", "OFF 3 1 0\n", "off\n3 1 0\n", "OFF3 1 0\n", "OFF\n3 1\n", "OFF\n3\n1\n0\n",
        "# made by hand\nOFF # here\n# and here\n3 1 3 # edges\n", "\xef\xbb\xbfOFF\n3 1 0\n",
        "OFF\n3 1 0\n# the vertices\n"})
    ExpectTriangle(Plain(head + body));
  std::string windows = "OFF\n3 1 0\n" + body, mac = windows;
  for (std::size_t at = 0; (at = windows.find('\n', at)) != windows.npos; at += 2)
    windows.insert(at, "\r");
  std::replace(mac.begin(), mac.end(), '\n', '\r');
  ExpectTriangle(Plain(windows));
  ExpectTriangle(Plain(mac));
  // Vertices over lines as they like: Geomview's four numbers for a colour.
  ExpectTriangle(Plain("OFF 3 1 0\n0\n0 0\n2 0 0 0 4\n0\n3 0 1 2\n"));
  const Mesh spread =
      Plain("COFF 3 1 0\n0 0 0\n1 0 0 1\n2 0 0\n0 0.2 0 1\n0 4 0\n0 0 1 1\n3 0 1 2\n");
  ExpectTriangle(spread);
  EXPECT_EQ(ColorOf(spread, 1), Eigen::RowVector3i(0, 51, 0));
  const Mesh square = Plain("OFF\n4 1 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3 10 20 30\n");
  EXPECT_EQ(square.face_count(), 2);
  EXPECT_EQ(ColorOf(square, 3), Eigen::RowVector3i(10, 20, 30));
}

std::string Big(std::uint32_t value) { return BigEndian32(value); }
std::string Real(float value) {
  std::uint32_t bits = 0;
  std::memcpy(&bits, &value, 4);
  return Big(bits);
}
std::string Reals(std::initializer_list<float> values) {
  std::string bytes;
  for (const float value : values) bytes += Real(value);
  return bytes;
}

TEST_F(OffFile, BinaryColors) {
  const std::string counts = Big(3) + Big(1) + Big(0), face = Big(3) + Big(0) + Big(1) + Big(2);
  const std::string points = Reals({0, 0, 0, 2, 0, 0, 0, 4, 0});
  ExpectTriangle(Plain("OFF BINARY\n" + counts + points + face + Big(0)));
  const Mesh faces = Plain("OFF BINARY\n" + counts + points + face + Big(3) + Reals({1, 0.2f, 0}));
  ExpectTriangle(faces);
  EXPECT_EQ(ColorOf(faces, 2), Eigen::RowVector3i(255, 51, 0));
  // Geomview's, and CGAL's with a count before each colour.
  for (const bool counted : {false, true}) {
    const std::string count = counted ? Big(4) : "", color = count + Reals({1, 0.2f, 0, 1});
    const Mesh mesh = Plain("COFF BINARY\n" + counts + Reals({0, 0, 0}) + color + Reals({2, 0, 0}) +
                            color + Reals({0, 4, 0}) + color + face + Big(0));
    ExpectTriangle(mesh);
    EXPECT_EQ(ColorOf(mesh, 1), Eigen::RowVector3i(255, 51, 0)) << counted;
  }
  const Mesh normals = Plain("NOFF BINARY\n" + counts + Reals({0, 0, 0, 0, 0, 1}) +
                             Reals({2, 0, 0, 0, 0, 1}) + Reals({0, 4, 0, 0, 0, 1}) + face + Big(0));
  ExpectTriangle(normals);
  EXPECT_EQ(normals.normals.row(2), Eigen::RowVector3d(0, 0, 1));
  std::string little = counts + points + face + Big(0);
  for (std::size_t i = 0; i < little.size(); i += 4)
    std::reverse(little.begin() + static_cast<std::ptrdiff_t>(i),
                 little.begin() + static_cast<std::ptrdiff_t>(i + 4));
  ExpectTriangle(Plain("OFF BINARY\n" + little));
  EXPECT_THAT(Refusal("OFF BINARY\n" + counts + points + face + Big(9)),
              HasSubstr("9 numbers for its colour"));
  EXPECT_THAT(Refusal("OFF BINARY\n" + counts + points + face), HasSubstr("truncated"));
  EXPECT_THAT(Refusal("OFF BINARY\n" + counts + points + face + Big(0) + "more"),
              HasSubstr("goes on after"));
}

TEST_F(OffFile, WhatIsNotReadIsSaidWithItsPlace) {
  EXPECT_THAT(
      Refusal(Triangle("OFF", "255 0 0", "0 0 0", "0 0 0")),
      HasSubstr("vertex 0 has 6 numbers, and OFF says 3: files with normals begin with NOFF"));
  EXPECT_THAT(Refusal(Triangle("COFF", "255 0", "0 0", "0 0")),
              HasSubstr("vertex 0 has 2 numbers for its colour"));
  EXPECT_THAT(Refusal(Triangle("OFF", "", "", "", "1 2")), HasSubstr("2 numbers for its colour"));
  EXPECT_THAT(Refusal(Triangle("OFF", "", "", "", "1 2 3 4 5")), HasSubstr("more than four"));
  EXPECT_THAT(Refusal("OFF\n3 1 0\n0 0 0\n2 0 x\n0 4 0\n3 0 1 2\n"),
              HasSubstr("vertex 1 is malformed ('x' is no number)"));
  EXPECT_THAT(Refusal("OFF\n3 1 0\n0 0 0\n2 0 nan\n0 4 0\n3 0 1 2\n"), HasSubstr("vertex 1"));
  EXPECT_THAT(Refusal("OFF\n3 1 0\n0 0 0\n2 0 0\n0 4 0\n3 0 1 3\n"),
              HasSubstr("face 0 names vertex 3, but the file has 3"));
  EXPECT_THAT(Refusal("OFF\n3 1 0\n0 0 0\n2 0 0\n0 4 0\n3 0 1.5 2\n"), HasSubstr("not whole"));
  EXPECT_THAT(Refusal("OFF\n3 2 0\n0 0 0\n2 0 0\n0 4 0\n3 0 1 2\n"), HasSubstr("ends at face 1"));
  EXPECT_THAT(Refusal("OFF\n3 1 0\n0 0 0\n2 0 0\n0 4 0\n3 0 1 2\n3 0 2 1\n"),
              HasSubstr("goes on after its 3 vertices and 1 faces"));
  EXPECT_THAT(Refusal("3 1 0\n0 0 0\n2 0 0\n0 4 0\n3 0 1 2\n"),
              HasSubstr("does not begin with the word OFF"));
}

TEST(OffKeyword, IsToldFromOtherWords) {
  for (const char* text : {"OFF\n", "coff\n", "STCN4nOFF\n", "NCOFF", "OFF490 518 0", "# a\nOFF"})
    EXPECT_TRUE(LooksLikeOff(text)) << text;
  for (const char* text :
       {"o coffee", "coffee", "s off", "office", "g OFF", "XOFF", "OFFER", "", "#", "# OFF"})
    EXPECT_FALSE(LooksLikeOff(text)) << text;
}

}  // namespace keypose::off_file_test
