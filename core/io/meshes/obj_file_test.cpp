// Each statement of OBJ is read, skipped because it tells nothing of the surface, or refused.
#include "core/io/meshes/obj_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/io/text/files.h"
#include "core/testing/folder.h"
#include "core/values/errors.h"

namespace keypose::obj_file_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

const std::string kSquare = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

class ObjFileTest : public ::testing::Test, public TestingFolder {
 protected:
  ObjFile Read(const std::string& text) {
    WriteFile(folder_ / "a.obj", text);
    return ReadObj(folder_ / "a.obj");
  }
  std::string Refusal(const std::string& text) {
    try {
      Read(text);
    } catch (const InputError& error) {
      return error.what();
    }
    return "was read";
  }
};

TEST_F(ObjFileTest, PolygonsAreKeptWhereAnyHasMoreThanThreeCorners) {
  using ::testing::IsEmpty;
  EXPECT_THAT(Read(kSquare + "f 1 2 3 4\nf 1 2\nf 1 3 4\n").polygons.sizes, ElementsAre(4, 3));
  const ObjFile triangles = Read(kSquare + "f 1 2 3\nf 1 2\nf 1 3 4\n");
  EXPECT_EQ(triangles.mesh.face_count(), 2);
  EXPECT_THAT(triangles.polygons.sizes, IsEmpty());
  EXPECT_THAT(triangles.polygons.corners, IsEmpty());
}

TEST_F(ObjFileTest, FacesOfAllForms) {
  const FacesX3 right = Read(kSquare + "f 1 2 3\nf 1 3 4\n").mesh.faces;
  const std::string more = kSquare + "vt 0 0\nvt 1 0 0\nvt 1\nvt 0 1\nvn 0 0 1\n";
  for (const char* faces :
       {"f 1 2 3 4\n", "f\t1\t2\t3\t4\n", "f -4 -3 -2 -1\n", "f 1/1 2/2 3/3 4/4\n",
        "f 1//1 2//1 3//1 4//1\n", "f 1/1/1 2/2/1 3/3/1 4/4/1\n", "f -4/-4/-1 -3/-3 -2/-2 -1/-1\n",
        "fo 1 2 3 4\n", "f 1 2 \\\n3 4\n", "f 1 2 3 4 # the front\n", "  f 1/ 2/ 3/ 4/\r\n",
        "f +1 2 3 4"})
    EXPECT_EQ(Read(more + faces).mesh.faces, right) << faces;
  const Mesh textured = Read(more + "f 1/1 2/2 3/3\n").mesh;
  ASSERT_TRUE(textured.has_uvs());
  EXPECT_EQ(textured.uvs.row(2), Eigen::RowVector2d(1, 0)) << "a texture of one dimension";
}

TEST_F(ObjFileTest, LinesOfAllSystems) {
  const FacesX3 right = Read(kSquare + "f 1 2 3 4\n").mesh.faces;
  for (const std::string end : {"\r\n", "\r"}) {
    std::string text;
    for (const char c : kSquare + "f 1 2 3 4\n") text += c == '\n' ? end : std::string(1, c);
    EXPECT_EQ(Read(text).mesh.faces, right);
  }
  const std::string comment = "# made of C:\\Scans\\\n";
  EXPECT_EQ(Read(comment + kSquare + "f 1 2 3 4\n").mesh.faces, right);
  EXPECT_EQ(Read("\xef\xbb\xbf" + kSquare + "f 1 2 3 4\n").mesh.faces, right);
}

TEST_F(ObjFileTest, NumbersKeepTheirDigits) {
  const Mesh mesh =
      Read("v 500000.1234567891 4649776.5 1e-320\nv +1 -2.5E+1 .5\nv 0 0 0\nf 1 2 3\n").mesh;
  EXPECT_EQ(mesh.points(0, 0), 500000.1234567891);
  EXPECT_NEAR(mesh.points(0, 2), 0, 1e-300);
  EXPECT_EQ(mesh.points.row(1), Eigen::RowVector3d(1, -25, 0.5));
}

TEST_F(ObjFileTest, WeightsAndColorsBehindPositions) {
  const auto colors = [&](const std::string& tail) {
    const Mesh mesh =
        Read("v 0 0 0 " + tail + "\nv 1 0 0 " + tail + "\nv 0 1 0 " + tail + "\nf 1 2 3\n").mesh;
    EXPECT_EQ(mesh.points.row(1), Eigen::RowVector3d(1, 0, 0));
    return mesh.colors.rows() == 0 ? Eigen::RowVector3i(-1, -1, -1)
                                   : Eigen::RowVector3i(mesh.colors.row(1).cast<int>());
  };
  EXPECT_EQ(colors(""), Eigen::RowVector3i(-1, -1, -1));
  EXPECT_EQ(colors("1.0"), Eigen::RowVector3i(-1, -1, -1));
  EXPECT_EQ(colors("0.2 0.4 1"), Eigen::RowVector3i(51, 102, 255));
  EXPECT_EQ(colors("51 102 255"), Eigen::RowVector3i(51, 102, 255));
  EXPECT_EQ(colors("1.0 0.2 0.4 0.6"), Eigen::RowVector3i(51, 102, 153));
  EXPECT_EQ(colors("0.2 0.4 0.6 1.0"), Eigen::RowVector3i(51, 102, 153));
  EXPECT_THAT(Refusal("v 0 0 0 1 2\n"), HasSubstr("has 5 numbers"));
  EXPECT_THAT(Refusal("v 0 0 0 1 2 3 4 5\n"), HasSubstr("has 8 numbers"));
}

TEST_F(ObjFileTest, VerticesWithoutAColorTakeTheirNeighbours) {
  const Mesh mesh = Read("v 0 0 0 0.2 0.4 0.6\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").mesh;
  for (int v = 0; v < 3; ++v)
    EXPECT_EQ(mesh.colors.row(v).cast<int>(), Eigen::RowVector3i(51, 102, 153));
}

TEST_F(ObjFileTest, AColorThatIsNoNumberIsNone) {
  const Mesh mesh = Read("v 0 0 0 1 0 0\nv 1 0 0 nan nan nan\nv 0 1 0 1 0 0\nf 1 2 3\n").mesh;
  ASSERT_EQ(mesh.colors.rows(), 3);
  EXPECT_EQ(int{mesh.colors(1, 0)}, 255) << "its neighbours'";
  EXPECT_EQ(int{mesh.colors(1, 1)}, 0);
  EXPECT_THAT(Refusal("v 0 nan 0\n"), HasSubstr("three finite numbers"));
}

TEST_F(ObjFileTest, PolypaintOfZbrush) {
  const Mesh mesh =
      Read("v 0 0 0\nv 1 0 0\nv 0 1 0\n#MRGB ffff0000ff00ff00\n#MRGB ff0000ff\nf 1 2 3\n").mesh;
  ASSERT_EQ(mesh.colors.rows(), 3);
  EXPECT_EQ(mesh.colors.cast<int>(), Eigen::Matrix3i(255 * Eigen::Matrix3i::Identity()));
}

TEST_F(ObjFileTest, MaterialsAndLibraries) {
  const ObjFile obj = Read("mtllib a.mtl b.mtl\nmtllib\tc d.mtl\r\n" + kSquare +
                           "usemtl unused\nf 1 2 3 4\nusemtl\tred cloth \r\nf 1 2 3\nusemtl "
                           "unused\nusemtl\nf 1 2 3\n");
  EXPECT_THAT(obj.libraries, ElementsAre("a.mtl b.mtl", "c d.mtl"));
  EXPECT_THAT(obj.materials, ElementsAre("unused", "red cloth", ""));
  EXPECT_THAT(obj.material_of_face, ElementsAre(0, 0, 1, 2));
  EXPECT_THAT(Read(kSquare + "f 1 2 3\nusemtl a\nf 1 3 4\n").materials, ElementsAre("", "a"));
}

TEST_F(ObjFileTest, WhatTellsNothingOfTheSurfaceIsSkipped) {
  for (const char* line : {"vn 0 0 1",
                           "vp 0.1",
                           "p 1",
                           "l 1 2",
                           "curv 0 1 1 2",
                           "curv2 1 2",
                           "cstype bezier",
                           "deg 3",
                           "bmat u 1 0",
                           "step 1",
                           "parm u 0 1",
                           "trim 0 1 1",
                           "hole 0 1 1",
                           "scrv 0 1 1",
                           "sp 1",
                           "end",
                           "con 1 0 1 1 2 0 1 1",
                           "g head",
                           "s off",
                           "mg 1 2",
                           "o fox",
                           "bevel on",
                           "c_interp on",
                           "d_interp on",
                           "lod 5",
                           "shadow_obj a.obj",
                           "trace_obj a.obj",
                           "ctech cparm 1",
                           "stech cparma 1 1",
                           "usemap off",
                           "maplib a.map",
                           "# v 9 9 9",
                           "vendor thing"})
    EXPECT_EQ(Read(kSquare + line + "\nf 1 2 3\n").mesh.face_count(), 1) << line;
  EXPECT_TRUE(Read(kSquare + "usemap skin\nf 1 2 3\n").has_texture_maps);
}

TEST_F(ObjFileTest, WhatIsNotReadIsRefusedByName) {
  EXPECT_THAT(Refusal(kSquare + "surf 0 1 0 1 1 2 3 4\n"),
              ::testing::AllOf(HasSubstr("a.obj:5: 'surf"), HasSubstr("free-form surface")));
  for (const char* line : {"bzp 1 2", "bsp 1 2", "cdc 1 2", "cdp 1 2", "res 1 2"})
    EXPECT_THAT(Refusal(kSquare + line), HasSubstr("free-form surface")) << line;
  EXPECT_THAT(Refusal("call other.obj\n"), HasSubstr("from elsewhere"));
  EXPECT_THAT(Refusal("csh ls\n"), HasSubstr("from elsewhere"));
  EXPECT_THAT(Refusal("v 0,5 0,1 1,0\n"), HasSubstr("decimal marks"));
  EXPECT_THAT(Refusal("v 0 0\n"), HasSubstr("three finite numbers"));
  EXPECT_THAT(Refusal("v 1e999 0 0\n"), HasSubstr("three finite numbers"));
  EXPECT_THAT(Refusal("v 0 0 0\nvt nan 0\n"), HasSubstr("a.obj:2: 'vt nan 0'"));
  EXPECT_THAT(Refusal(kSquare + "f 1 2 x\n"), HasSubstr("a corner whose vertex is no number"));
  EXPECT_THAT(Refusal(kSquare + "f 1 2 0\n"), HasSubstr("count from 1"));
  EXPECT_THAT(Refusal(kSquare + "f 1 2 -5\n"), HasSubstr("names the vertex -5"));
  EXPECT_THAT(Refusal(kSquare + "f 1 2 99999999999\n"), HasSubstr("names the vertex 99999999999"));
  EXPECT_THAT(Refusal(kSquare + "f 1 2 5\n"), HasSubstr("names vertex 4, but the file has 4"));
}

TEST_F(ObjFileTest, ColorsOnLinesOfTheirOwn) {
  const std::string vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\n",
                    three = "vc 1 0 0\nvc 0 0.2 0\nvc 0 0 1\n";
  const ObjFile in_order = Read(vertices + three + "f 1 2 3\n");
  ASSERT_EQ(in_order.mesh.colors.rows(), 3);
  EXPECT_EQ(in_order.mesh.colors.row(1).cast<int>(), Eigen::RowVector3i(0, 51, 0));
  const ObjFile by_corner = Read(vertices + three + "f 1///3 2///1 3///2\n");
  ASSERT_EQ(by_corner.mesh.colors.rows(), 3);
  EXPECT_EQ(by_corner.mesh.colors.row(0).cast<int>(), Eigen::RowVector3i(0, 0, 255));
  EXPECT_EQ(by_corner.mesh.colors.row(1).cast<int>(), Eigen::RowVector3i(255, 0, 0));
  const ObjFile fewer = Read(vertices + "vc 1 0 0\nf 1 2 3\n");
  EXPECT_EQ(fewer.mesh.colors.rows(), 0);
  EXPECT_THAT(fewer.left_out,
              ElementsAre("its 1 colours (vc) are left out, because it has 3 vertices"));
  EXPECT_THAT(Refusal(vertices + "vc 1 0\n"), HasSubstr("is not a colour"));
}

TEST_F(ObjFileTest, LinesThatNobodyKnowsAreNamed) {
  EXPECT_THAT(Read(kSquare + "vendor thing\nvendor other\nf 1 2 3\n").left_out,
              ElementsAre("its lines 'vendor' are not known and were left out"));
  EXPECT_THAT(Read(kSquare + "vn 0 0 1\ng a\n# vendor\nf 1 2 3\n").left_out, ::testing::IsEmpty());
  EXPECT_THAT(Read("v 0 0 0\n#MRGB ffff0000ff00ff00\n").left_out, ElementsAre(HasSubstr("#MRGB")));
}

}  // namespace keypose::obj_file_test
