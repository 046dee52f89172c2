// The container and the JSON of a glTF; what they mean for the mesh is in gltf_features_test.cpp.
#include "core/io/meshes/gltf_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/io/text/files.h"
#include "core/testing/folder.h"
#include "core/values/errors.h"

namespace keypose::gltf_file_test {

using ::testing::HasSubstr;

class GltfFileTest : public ::testing::Test, public TestingFolder {
 protected:
  std::filesystem::path Put(const std::string& json) {
    WriteFile(folder_ / "a.gltf", R"({"asset": {"version": "2.0"}, )" + json + "}");
    return folder_ / "a.gltf";
  }
  std::string Refusal(const std::string& json) {
    try {
      GltfFile file(Put(json));
    } catch (const InputError& error) {
      return error.what();
    }
    return "was read";
  }
};

TEST_F(GltfFileTest, TheBeginningTells) {
  EXPECT_TRUE(LooksLikeGltf("glTF\x02"));
  EXPECT_TRUE(LooksLikeGltf("\xef\xbb\xbf \n{\"asset\""));
  EXPECT_FALSE(LooksLikeGltf("v 0 0 0"));
  EXPECT_FALSE(LooksLikeGltf(""));
}

TEST_F(GltfFileTest, PartsHaveTheirNumbers) {
  const GltfFile file(Put(R"(
      "nodes": [{"translation": [1, 2, 3], "scale": [2, 2, 2], "children": [1]},
                {"matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 7, 8, 9, 1], "weights": [0.5]}],
      "samplers": [{"wrapS": 33071}], "images": [{"bufferView": 3}],
      "textures": [{"sampler": 0, "source": 0}],
      "materials": [{"pbrMetallicRoughness": {"baseColorFactor": [0.1, 0.2, 0.3, 0.4],
        "baseColorTexture": {"index": 0, "texCoord": 1, "extensions": {"KHR_texture_transform":
          {"offset": [0.25, 0.5], "scale": [2, 4]}}}}}],
      "accessors": [{"bufferView": 2, "componentType": 5121, "count": 7, "type": "VEC4",
                     "normalized": true}])"));
  EXPECT_EQ(file.nodes[0].parent_from_node * Eigen::Vector3d(1, 1, 1), Eigen::Vector3d(3, 4, 5));
  EXPECT_EQ(file.nodes[1].parent_from_node * Eigen::Vector3d(1, 1, 1), Eigen::Vector3d(8, 9, 10));
  EXPECT_THAT(file.roots, ::testing::ElementsAre(0)) << "without a scene: what lies in no other";
  EXPECT_EQ(file.textures[0].wrap_u, Wrap::kClamp);
  EXPECT_EQ(file.textures[0].wrap_v, Wrap::kRepeat);
  EXPECT_EQ(file.materials[0].factor, Eigen::Vector3d(0.1, 0.2, 0.3));
  EXPECT_EQ(file.materials[0].color.uv_set, 1);
  EXPECT_EQ(file.materials[0].color.transform * Eigen::Vector2d(1, 1), Eigen::Vector2d(2.25, 4.5));
  EXPECT_EQ(file.accessors[0].columns, 4);
  EXPECT_EQ(file.accessors[0].count, 7u);
  EXPECT_TRUE(file.accessors[0].normalized);
}

TEST_F(GltfFileTest, DamageIsNamed) {
  EXPECT_THAT(Refusal(R"("scenes": [{}], "scene": 3)"), HasSubstr("a scene that does not exist"));
  EXPECT_THAT(Refusal(R"("nodes": [{"mesh": -2}])"), HasSubstr("mesh is no count"));
  EXPECT_THAT(Refusal(R"("nodes": [{"mesh": 1.5}])"), HasSubstr("mesh is no count"));
  EXPECT_THAT(Refusal(R"("nodes": [{"scale": [1, 2]}])"), HasSubstr("scale is too short"));
  EXPECT_THAT(Refusal(R"("nodes": [{"mesh": "fox"}])"), HasSubstr("it is damaged"));
  EXPECT_THAT(Refusal(R"("textures": [{"sampler": 0}])"), HasSubstr("a sampler"));
  EXPECT_THAT(Refusal(R"("buffers": [{"uri": "data:,text"}])"), HasSubstr("not base64"));
  EXPECT_THAT(Refusal(R"("buffers": [{"uri": "gone.bin"}])"), HasSubstr("gone.bin"));
}

}  // namespace keypose::gltf_file_test
