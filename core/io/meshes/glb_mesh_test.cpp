#include "core/io/meshes/glb_mesh.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tiny_gltf.h>

#include <functional>
#include <sstream>

#include "core/io/meshes/scan_file.h"
#include "core/io/pictures/picture_bytes.h"
#include "core/io/text/files.h"
#include "core/surfaces/geometry.h"
#include "core/testing/folder.h"
#include "core/values/errors.h"

namespace keypose::glb_mesh_test {

using ::testing::HasSubstr;

const std::string kPicture = "\x89PNG\r\n\x1a\n and so on";

int AddList(tinygltf::Model* model, const void* bytes, std::size_t size, std::size_t count,
            int type, int component) {
  tinygltf::BufferView view;
  view.buffer = 0, view.byteOffset = model->buffers[0].data.size(), view.byteLength = size;
  const auto* from = static_cast<const unsigned char*>(bytes);
  model->buffers[0].data.insert(model->buffers[0].data.end(), from, from + size);
  model->buffers[0].data.resize((model->buffers[0].data.size() + 3) / 4 * 4);
  model->bufferViews.push_back(view);
  tinygltf::Accessor accessor;
  accessor.bufferView = static_cast<int>(model->bufferViews.size()) - 1;
  accessor.count = count, accessor.type = type, accessor.componentType = component;
  model->accessors.push_back(accessor);
  return static_cast<int>(model->accessors.size()) - 1;
}

/// A square in glTF's xy plane whose two triangles have vertices of their own: 0 1 2 and 0 2 3,
/// with a picture, placed by a node.
tinygltf::Model Square() {
  tinygltf::Model model;
  model.asset.version = "2.0";
  model.buffers.resize(1);
  const float points[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 0, 0, 1, 1, 0, 0, 1, 0};
  const std::uint8_t uvs[] = {0, 0, 51, 0, 51, 51, 0, 0, 51, 51, 0, 51};
  const std::uint16_t corners[] = {0, 1, 2, 3, 4, 5};
  tinygltf::Primitive part;
  part.mode = TINYGLTF_MODE_TRIANGLES;
  part.attributes["POSITION"] =
      AddList(&model, points, sizeof points, 6, TINYGLTF_TYPE_VEC3, TINYGLTF_COMPONENT_TYPE_FLOAT);
  part.attributes["TEXCOORD_0"] = AddList(&model, uvs, sizeof uvs, 6, TINYGLTF_TYPE_VEC2,
                                          TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE);
  model.accessors.back().normalized = true;
  part.indices = AddList(&model, corners, sizeof corners, 6, TINYGLTF_TYPE_SCALAR,
                         TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT);
  AddList(&model, kPicture.data(), kPicture.size(), 0, TINYGLTF_TYPE_SCALAR,
          TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE);
  model.accessors.pop_back();
  model.images.resize(1);
  model.images[0].bufferView = 3, model.images[0].mimeType = "image/png";
  model.textures.resize(1);
  model.textures[0].source = 0;
  model.materials.resize(1);
  model.materials[0].pbrMetallicRoughness.baseColorTexture.index = 0;
  part.material = 0;
  model.meshes.resize(1);
  model.meshes[0].primitives = {part};
  model.nodes.resize(2);
  model.nodes[0].children = {1}, model.nodes[0].translation = {1, 2, 3};
  model.nodes[1].mesh = 0, model.nodes[1].scale = {2, 2, 2};
  model.scenes.resize(1);
  model.scenes[0].nodes = {0};
  model.defaultScene = 0;
  return model;
}

class GlbMeshTest : public ::testing::Test, public TestingFolder {
 protected:
  Scan Read(tinygltf::Model model, bool join = true) {
    std::ostringstream out;
    EXPECT_TRUE(tinygltf::TinyGLTF().WriteGltfSceneToStream(&model, out, false, true));
    WriteFile(folder_ / "a.glb", out.str());
    return ReadScan(folder_ / "a.glb", join);
  }
  void Refuse(const std::function<void(tinygltf::Model*)>& spoil, const std::string& why) {
    tinygltf::Model model = Square();
    spoil(&model);
    try {
      Read(model);
      ADD_FAILURE() << "was read: " << why;
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr("a.glb"));
      EXPECT_THAT(error.what(), HasSubstr(why));
    }
  }
};

TEST_F(GlbMeshTest, TheSceneIsPlacedZUpWithItsTexture) {
  const Scan read = Read(Square());
  EXPECT_THAT(read.warnings, ::testing::IsEmpty());
  EXPECT_EQ(read.texture, kPicture);
  EXPECT_EQ(read.texture_ending, ".png");
  ASSERT_EQ(read.mesh.points.rows(), 4) << "two were doubled";
  EXPECT_EQ(read.mesh.points.row(2), Eigen::RowVector3d(3, -3, 4));
  EXPECT_EQ(read.mesh.points.row(3), Eigen::RowVector3d(1, -3, 4));
  EXPECT_EQ(FaceNormals(read.mesh.points, read.mesh.faces).row(0), Eigen::RowVector3d(0, -1, 0));
  ASSERT_TRUE(read.mesh.has_uvs());
  EXPECT_NEAR(read.mesh.uvs(read.mesh.uv_faces(0, 2), 0), 0.2, 1e-12);
  EXPECT_NEAR(read.mesh.uvs(read.mesh.uv_faces(0, 2), 1), 0.8, 1e-12);
  EXPECT_EQ(Read(Square(), false).mesh.points.rows(), 6);
}

TEST_F(GlbMeshTest, AMirroredNodeKeepsTheOutsideOut) {
  tinygltf::Model model = Square();
  model.nodes[1].scale = {-2, 2, 2};
  const Mesh mesh = Read(model).mesh;
  EXPECT_EQ(FaceNormals(mesh.points, mesh.faces).row(1), Eigen::RowVector3d(0, -1, 0));
}

TEST_F(GlbMeshTest, WithoutATextureMaterialsColourTheVertices) {
  tinygltf::Model model = Square();
  auto& look = model.materials[0].pbrMetallicRoughness;
  look.baseColorTexture.index = -1;
  look.baseColorFactor = {1, 0, 0.2158605, 1};
  const Scan read = Read(model);
  EXPECT_EQ(read.texture, "");
  ASSERT_EQ(read.mesh.colors.rows(), 4);
  EXPECT_EQ(read.mesh.colors.row(3).cast<int>(), Eigen::RowVector3i(255, 0, 128));
  EXPECT_FALSE(read.mesh.has_uvs());
}

/// Puts another picture in the place of the square's.
void SetPicture(const std::string& bytes, tinygltf::Model* model) {
  auto& data = model->buffers[0].data;
  tinygltf::BufferView& view = model->bufferViews[3];
  view.byteOffset = data.size();
  view.byteLength = bytes.size();
  data.insert(data.end(), bytes.begin(), bytes.end());
  data.resize((data.size() + 3) / 4 * 4);
}

/// A picture of one colour.
std::string PictureOf(std::uint8_t red, std::uint8_t green) {
  Image8 image(10, 10, 3);
  for (int y = 0; y < 10; ++y)
    for (int x = 0; x < 10; ++x) {
      image.at(x, y)[0] = red;
      image.at(x, y)[1] = green;
    }
  return PngBytes(image);
}

TEST_F(GlbMeshTest, SeveralTexturesBecomeOne) {
  tinygltf::Model model = Square();
  SetPicture(PictureOf(200, 0), &model);
  model.bufferViews.push_back(model.bufferViews[3]);
  SetPicture(PictureOf(0, 100), &model);
  model.images.push_back(model.images[0]);
  model.images[1].bufferView = 4;
  model.textures.push_back({});
  model.textures[1].source = 1;
  model.materials.push_back(model.materials[0]);
  model.materials[1].pbrMetallicRoughness.baseColorTexture.index = 1;
  model.meshes[0].primitives.push_back(model.meshes[0].primitives[0]);
  model.meshes[0].primitives[1].material = 1;
  const Scan read = Read(model);
  EXPECT_THAT(read.warnings, ::testing::IsEmpty());
  EXPECT_EQ(read.texture_ending, ".png");
  const Image8 texture = DecodePicture(read.texture, "texture");
  ASSERT_EQ(read.mesh.face_count(), 4);
  for (int f = 0; f < 4; ++f)
    for (int k = 0; k < 3; ++k) {
      const auto uv = read.mesh.uvs.row(read.mesh.uv_faces(f, k));
      const int x = static_cast<int>(uv[0] * texture.width),
                y = static_cast<int>((1 - uv[1]) * texture.height);
      EXPECT_EQ(int{texture.at(x, y)[0]}, f < 2 ? 0 : 200) << f << " " << k;
      EXPECT_EQ(int{texture.at(x, y)[1]}, f < 2 ? 100 : 0) << f << " " << k;
    }
}

TEST_F(GlbMeshTest, APictureOfAnotherKindIsSaid) {
  tinygltf::Model model = Square();
  SetPicture("\xabKTX 20\xbb and so on", &model);
  const Scan read = Read(model);
  EXPECT_EQ(read.texture, "");
  EXPECT_THAT(read.warnings,
              ::testing::ElementsAre(HasSubstr("is a KTX picture (Basis Universal)")));
}

TEST_F(GlbMeshTest, DamagedFilesAreRefused) {
  using tinygltf::Model;
  Refuse([](Model* m) { m->meshes[0].primitives[0].material = 7; }, "material");
  Refuse([](Model* m) { m->nodes[1].children = {0}; }, "nodes that contain each other");
  Refuse([](Model* m) { m->accessors[0].count = 1000000000; }, "data that it does not have");
  Refuse([](Model* m) { m->accessors[0].byteOffset = 64; }, "data that it does not have");
  Refuse([](Model* m) { m->bufferViews[0].byteLength = 1 << 20; }, "data that it does not have");
  Refuse([](Model* m) { m->bufferViews[3].byteLength = 1 << 20; }, "data that it does not have");
  Refuse([](Model* m) { m->buffers[0].data[m->bufferViews[2].byteOffset] = 99; }, "corner");
  Refuse([](Model* m) { m->meshes[0].primitives[0].mode = TINYGLTF_MODE_LINE; }, "no triangles");
  Refuse([](Model* m) { m->extensionsRequired = {"ACME_folded"}; }, "the extension ACME_folded");
  WriteFile(folder_ / "a.glb", "PK and so on");
  EXPECT_THROW(ReadGlb(folder_ / "a.glb"), InputError);
  WriteFile(folder_ / "a.glb", "glTF");
  EXPECT_THROW(ReadGlb(folder_ / "a.glb"), InputError);
}

}  // namespace keypose::glb_mesh_test
