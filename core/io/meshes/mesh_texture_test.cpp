#include "core/io/meshes/mesh_texture.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/io/text/files.h"
#include "core/testing/folder.h"
#include "core/values/errors.h"

namespace keypose::mesh_texture_test {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

class MeshTextureTest : public ::testing::Test, public TestingFolder {
 protected:
  void Put(const std::string& name, const std::string& text) {
    fs::create_directories((folder_ / name).parent_path());
    WriteFile(folder_ / name, text);
  }
  MeshTexture Of(const std::string& mesh) { return FindTexture(folder_ / mesh); }
};

TEST_F(MeshTextureTest, AnObjsMaterialNamesIt) {
  Put("fox.obj", "mtllib fox scan.mtl\r\nv 0 0 0\nusemtl fur\r\nf 1 1 1\nusemtl unused\n");
  Put("fox scan.mtl",
      "newmtl unused\nmap_Kd eyes.png\n\nnewmtl fur\nKd 1 1 1\nmap_Kd -s 1 1 1 maps\\fur "
      "1.jpg\r\n");
  EXPECT_EQ(Of("fox.obj").file, "");
  EXPECT_THAT(Of("fox.obj").why, HasSubstr("maps\\fur 1.jpg, which is not there"));
  Put("maps/fur 1.jpg", "picture");
  EXPECT_EQ(Of("fox.obj").file, folder_ / "maps/fur 1.jpg");
  EXPECT_EQ(Of("fox.obj").why, "");
}

TEST_F(MeshTextureTest, OfAPathThatLeadsElsewhereTheFileBesideTheMeshIsTaken) {
  Put("away/secret.png", "picture");
  for (const std::string name :
       {"../away/secret.png", "/etc/secret.png", "C:\\Scans\\secret.png"}) {
    Put("in/fox.obj", "mtllib fox.mtl\nusemtl fur\nf 1 1 1\n");
    Put("in/fox.mtl", "newmtl fur\nmap_Kd " + name + "\n");
    EXPECT_EQ(Of("in/fox.obj").file, "") << name;
    Put("in/secret.png", "picture");
    EXPECT_EQ(Of("in/fox.obj").file, folder_ / "in/secret.png") << name;
    fs::remove(folder_ / "in/secret.png");
  }
}

TEST_F(MeshTextureTest, SeveralTexturesAndMissingMaterialsAreSaid) {
  Put("a.obj", "mtllib a.mtl\nusemtl fur\nf 1 1 1\nusemtl eyes\nf 1 1 1\n");
  EXPECT_THAT(Of("a.obj").why, HasSubstr("materials in a.mtl, which is not there"));
  Put("a.mtl", "newmtl fur\nmap_Kd a.png\nnewmtl eyes\nmap_Kd b.png\n");
  EXPECT_THAT(Of("a.obj").why, HasSubstr("has 2 textures"));
  Put("a.mtl", "newmtl fur\nmap_Kd a.png\nnewmtl eyes\nKd 0 0 0\n");
  Put("a.png", "picture");
  EXPECT_EQ(Of("a.obj").file, folder_ / "a.png");
}

TEST_F(MeshTextureTest, APlysCommentNamesIt) {
  Put("a.ply", "ply\nformat ascii 1.0\ncomment TextureFile a.png\nelement vertex 0\nend_header\n");
  Put("a.png", "picture");
  EXPECT_EQ(Of("a.ply").file, folder_ / "a.png");
  Put("b.ply", "ply\nformat ascii 1.0\nend_header\ncomment TextureFile a.png\n");
  EXPECT_EQ(Of("b.ply").file, "");
  EXPECT_EQ(Of("b.ply").why, "");
}

TEST_F(MeshTextureTest, MeshesWithoutOneSayNothing) {
  Put("a.obj", "v 0 0 0\nf 1 1 1\n");
  Put("a.stl", "solid a\nendsolid a\n");
  for (const char* name : {"a.obj", "a.stl"}) {
    EXPECT_EQ(Of(name).file, "");
    EXPECT_EQ(Of(name).why, "");
  }
  EXPECT_THROW(Of("none.obj"), DiskError);
}

}  // namespace keypose::mesh_texture_test
