// How materials become pages; files and names are in scan_file_test.cpp.
#include "core/io/meshes/obj_look.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/io/text/files.h"
#include "core/testing/folder.h"

namespace keypose::obj_look_test {

using ::testing::ElementsAre;

class ObjLookTest : public ::testing::Test, public TestingFolder {
 protected:
  ObjLook Look(const std::string& faces, const std::string& mtl) {
    WriteFile(folder_ / "a.obj",
              "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\n" + faces);
    WriteFile(folder_ / "a.mtl", mtl);
    for (const char* name : {"a.png", "b.png"}) WriteFile(folder_ / name, name);
    return LookOfObj(folder_ / "a.obj", ReadObj(folder_ / "a.obj"));
  }
};

const std::string kFace = "f 1/1 2/2 3/3\n";

TEST_F(ObjLookTest, MaterialsOfOneTextureAreOnePage) {
  const ObjLook look =
      Look("usemtl a\n" + kFace + "usemtl b\n" + kFace + "usemtl c\n" + kFace,
           "newmtl a\nmap_Kd a.png\nnewmtl b\nmap_Kd b.png\nnewmtl c\nmap_Kd a.png\n");
  EXPECT_THAT(look.paged.page_of_face, ElementsAre(0, 1, 0));
  EXPECT_THAT(look.files, ElementsAre(folder_ / "a.png", folder_ / "b.png"));
  EXPECT_EQ(look.paged.pictures[1].bytes, "b.png");
  EXPECT_TRUE(look.moved);
}

TEST_F(ObjLookTest, AClampedTextureIsAPageOfItsOwn) {
  const ObjLook look = Look("usemtl a\n" + kFace + "usemtl b\n" + kFace,
                            "newmtl a\nmap_Kd a.png\nnewmtl b\nmap_Kd -clamp on a.png\n");
  EXPECT_THAT(look.paged.page_of_face, ElementsAre(0, 1));
  EXPECT_EQ(look.paged.pages[1].wrap_u, Wrap::kClamp);
  EXPECT_EQ(look.paged.pictures.size(), 1u);
}

TEST_F(ObjLookTest, TilesOfUdimAreNamed) {
  const ObjLook look = Look("usemtl a\n" + kFace, "newmtl a\nmap_Kd skin.<UDIM>.png\n");
  ASSERT_FALSE(look.warnings.empty());
  EXPECT_NE(look.warnings[0].find("skin.<UDIM>.png stands for UDIM tiles"), std::string::npos)
      << look.warnings[0];
}

TEST_F(ObjLookTest, FacesWithoutATextureHaveTheirMaterialsColor) {
  const ObjLook look = Look("usemtl a\n" + kFace + "usemtl b\n" + kFace,
                            "newmtl a\nmap_Kd a.png\nnewmtl b\nKd 1 0 0.5\n");
  EXPECT_THAT(look.paged.page_of_face, ElementsAre(0, -1));
  ASSERT_EQ(look.paged.corner_colors.size(), 2u);
  EXPECT_NEAR(look.paged.corner_colors[1][2][2], 0.21404114, 1e-7) << "linear light";
}

}  // namespace keypose::obj_look_test
