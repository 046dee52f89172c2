// STL as text and binary, and the colours that programs put into it.
#include "core/io/meshes/stl_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "core/io/meshes/face_colors.h"
#include "core/io/meshes/mesh_io.h"
#include "core/io/meshes/scan_file.h"
#include "core/io/testing/damaged_file.h"

namespace keypose::stl_file_test {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class StlFile : public HostileFile {
 protected:
  NotedMesh Read(const std::string& bytes, const std::string& name = "a.stl") const {
    const fs::path path = Put(name, bytes);
    EXPECT_EQ(MeshKindOf(path), MeshKind::kStl);
    return ReadStl(path);
  }
  std::string Refusal(const std::string& bytes) const { return MeshMessage(Put("a.stl", bytes)); }
};

void PutReal(float value, std::string* bytes) {
  bytes->append(reinterpret_cast<const char*>(&value), 4);
}

/// Two triangles of a unit square with these attributes.
std::string Binary(std::uint16_t first, std::uint16_t second, const std::string& header = "") {
  std::string bytes = header;
  bytes.resize(80);
  bytes += std::string("\2\0\0\0", 4);
  for (const bool other : {false, true}) {
    for (const float n : {0.f, 0.f, 1.f}) PutReal(n, &bytes);
    for (const float x : {0.f, 0.f, 0.f}) PutReal(x, &bytes);
    for (const float x : {other ? 1.f : 1.f, other ? 1.f : 0.f, 0.f}) PutReal(x, &bytes);
    for (const float x : {other ? 0.f : 1.f, 1.f, 0.f}) PutReal(x, &bytes);
    const std::uint16_t attribute = other ? second : first;
    bytes.append(reinterpret_cast<const char*>(&attribute), 2);
  }
  return bytes;
}

Eigen::RowVector3i ColorOf(const Mesh& mesh, int vertex) {
  if (mesh.colors.rows() <= vertex) return {-1, -1, -1};
  return mesh.colors.row(vertex).cast<int>();
}

void ExpectSquare(const Mesh& mesh) {
  ASSERT_EQ(mesh.vertex_count(), 4);
  ASSERT_EQ(mesh.face_count(), 2);
  EXPECT_EQ(mesh.points.row(1), Eigen::RowVector3d(1, 0, 0));
  EXPECT_EQ(mesh.points.row(3), Eigen::RowVector3d(0, 1, 0));
  EXPECT_EQ(mesh.faces.row(1), Eigen::RowVector3i(0, 2, 3));
}

TEST_F(StlFile, WithoutColors) {
  const NotedMesh plain = Read(Binary(0, 0));
  ExpectSquare(plain.mesh);
  EXPECT_EQ(plain.mesh.colors.rows(), 0);
  EXPECT_THAT(plain.notes, IsEmpty());
  // A bit that VisCAM and SolidView need is not set.
  EXPECT_EQ(Read(Binary(31, 31)).mesh.colors.rows(), 0);
  ExpectSquare(Read(Binary(0, 0, "solid as some programs begin")).mesh);
  ExpectSquare(Read(Binary(0, 0, "OFF is no keyword here")).mesh);
  ExpectSquare(Read(Binary(0, 0), "a.ply").mesh);
}

constexpr std::uint16_t kValid = 0x8000;

TEST_F(StlFile, ColorsOfViscamAndSolidview) {
  const std::uint16_t red = kValid | 31 << 10, blue = kValid | 31, green = kValid | 16 << 5;
  const NotedMesh one = Read(Binary(red, red));
  ExpectSquare(one.mesh);
  EXPECT_THAT(one.notes, IsEmpty());
  for (int v = 0; v < 4; ++v) EXPECT_EQ(ColorOf(one.mesh, v), Eigen::RowVector3i(255, 0, 0));
  EXPECT_EQ(ColorOf(Read(Binary(blue, blue)).mesh, 0), Eigen::RowVector3i(0, 0, 255));
  EXPECT_EQ(ColorOf(Read(Binary(green, green)).mesh, 0),
            Eigen::RowVector3i(0, static_cast<int>(std::lround(16 * 255 / 31.0)), 0));
  const NotedMesh two = Read(Binary(red, blue));
  EXPECT_EQ(ColorOf(two.mesh, 1), Eigen::RowVector3i(255, 0, 0));
  EXPECT_EQ(ColorOf(two.mesh, 3), Eigen::RowVector3i(0, 0, 255));
  EXPECT_THAT(two.notes, ElementsAre(kColorsBlend));
  const Scan scan = ReadScan(folder_ / "a.stl");
  EXPECT_EQ(scan.mesh.colors, two.mesh.colors);
  EXPECT_EQ(ReadMesh(folder_ / "a.stl").colors, two.mesh.colors);
  EXPECT_THAT(scan.warnings, ElementsAre(HasSubstr("a.stl: colours of its faces become")));
  EXPECT_EQ(ColorOf(Read(Binary(red, 0)).mesh, 3), Eigen::RowVector3i(255, 0, 0))
      << "its neighbours'";
}

TEST_F(StlFile, ColorsOfMagics) {
  const std::string header = std::string("made by hand COLOR=") + "\x0a\x14\x1e\xff" + ",MATERIAL=";
  // The bit is inverted, and red is lowest.
  const NotedMesh own = Read(Binary(31, 31, header));
  EXPECT_EQ(ColorOf(own.mesh, 0), Eigen::RowVector3i(255, 0, 0));
  const NotedMesh all = Read(Binary(kValid, kValid | 0x7fff, header));
  for (int v = 0; v < 4; ++v) EXPECT_EQ(ColorOf(all.mesh, v), Eigen::RowVector3i(10, 20, 30));
  EXPECT_THAT(all.notes, IsEmpty());
  const NotedMesh mixed = Read(Binary(31 << 10, kValid, header));
  EXPECT_EQ(ColorOf(mixed.mesh, 1), Eigen::RowVector3i(0, 0, 255));
  EXPECT_EQ(ColorOf(mixed.mesh, 3), Eigen::RowVector3i(10, 20, 30));
  // MeshLab 2020.09 and toxiclibs set the bit, and mean the face's own colour.
  EXPECT_EQ(ColorOf(Read(Binary(kValid | 31, kValid | 31, header)).mesh, 0),
            Eigen::RowVector3i(255, 0, 0));
  EXPECT_EQ(ColorOf(Read(Binary(0, 0, header)).mesh, 0), Eigen::RowVector3i(10, 20, 30))
      << "no face has any";
  EXPECT_EQ(Read(Binary(kValid, kValid, "COLOR=\xc8\xc8\xc8\xff")).mesh.colors.rows(), 0)
      << "grey is what a mesh without colours is";
}

TEST_F(StlFile, CountsThatDoNotFit) {
  const std::string whole = Binary(0, 0);
  const NotedMesh longer = Read(whole + "trailing bytes");
  ExpectSquare(longer.mesh);
  EXPECT_THAT(longer.notes, ElementsAre("14 bytes behind its 2 triangles are left out"));
  EXPECT_THAT(ReadScan(Put("b.stl", whole + "x")).warnings,
              ElementsAre("b.stl: 1 bytes behind its 2 triangles are left out"));
  ExpectSquare(Read(whole + "x", "named.otherwise").mesh);
  EXPECT_THAT(Refusal(whole.substr(0, 150)),
              HasSubstr("claims 2 triangles and holds 1; it is truncated"));
  EXPECT_THAT(Refusal(Binary(0, 0, "solid").substr(0, 150)), HasSubstr("it is truncated"));
  std::string none = whole;
  none[80] = 0;
  EXPECT_THAT(Refusal(none), HasSubstr("claims 0 triangles, but has 100 bytes"));
  std::string odd = whole;
  const float nan = std::nanf("");
  std::memcpy(odd.data() + 96, &nan, 4);
  EXPECT_THAT(Refusal(odd), HasSubstr("triangle 0 has a corner that is not finite"));
}

std::string Text(const std::string& inner) {
  return "solid a name\n" + inner + "endsolid a name\n";
}
const std::string kFacet =
    "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 1 1 0\nendloop\n"
    "endfacet\n";

TEST_F(StlFile, TextOfAnyCaseAndManySolids) {
  std::string capitals = Text(kFacet);
  for (char& c : capitals) c = static_cast<char>(std::toupper(c));
  for (const std::string& text :
       {Text(kFacet), capitals, "\xef\xbb\xbf" + Text(kFacet), "  solid\n" + kFacet + "endsolid",
        "solid facet of a gem\r\n" + kFacet + "endsolid\r\n",
        std::string(
            "solid t facet normal 0 0 1 outer loop vertex 0 0 0 vertex 1 0 0 vertex 1 1 0 endloop "
            "endfacet endsolid t")}) {
    const NotedMesh noted = Read(text);
    ASSERT_EQ(noted.mesh.face_count(), 1) << text;
    EXPECT_EQ(noted.mesh.points.row(2), Eigen::RowVector3d(1, 1, 0));
    EXPECT_THAT(noted.notes, IsEmpty());
  }
  EXPECT_EQ(Read(Text(kFacet) + Text(kFacet)).mesh.face_count(), 2);
  EXPECT_EQ(Read(Text(kFacet) + Text(kFacet)).mesh.vertex_count(), 3);
  EXPECT_EQ(Read(Text("")).mesh.face_count(), 0);
  EXPECT_THAT(Read(Text("color 0.5 0.5 1\n" + kFacet)).notes,
              ElementsAre(HasSubstr("colours of its solids")));
}

TEST_F(StlFile, DamagedTextIsNamedWithItsLine) {
  EXPECT_THAT(Refusal("solid a\n" + kFacet), AllOf(HasSubstr("a.stl"), HasSubstr("endsolid")));
  EXPECT_THAT(Refusal(Text(kFacet.substr(0, 36))), HasSubstr("malformed"));
  EXPECT_THAT(Refusal(Text("facet normal 0 0 1\nouter loop\nvertex 0 0 x\n")),
              HasSubstr("line 4: 'x' is no finite number"));
  std::string quad = kFacet;
  quad.insert(quad.find("endloop"), "vertex 0 1 0\n");
  EXPECT_THAT(Refusal(Text(quad)), HasSubstr("more than three corners"));
  EXPECT_THAT(Refusal(Text("mesh\n")), HasSubstr("'mesh' is malformed"));
}

}  // namespace keypose::stl_file_test
