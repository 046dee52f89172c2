#include "core/io/meshes/gltf_data.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/io/text/files.h"
#include "core/testing/folder.h"
#include "core/values/errors.h"

namespace keypose::gltf_data_test {

using ::testing::HasSubstr;

/// Eight bytes 0 to 7 beside it, in a view of them all and one of the second half.
class GltfDataTest : public ::testing::Test, public TestingFolder {
 protected:
  std::filesystem::path Put(const std::string& accessor) {
    WriteFile(folder_ / "a.bin", std::string("\0\1\2\3\4\5\6\7", 8));
    WriteFile(folder_ / "a.gltf", R"({"asset": {"version": "2.0"},
        "buffers": [{"uri": "a.bin", "byteLength": 8}],
        "bufferViews": [{"buffer": 0, "byteLength": 8},
                        {"buffer": 0, "byteOffset": 4, "byteLength": 4, "byteStride": 2},
                        {"buffer": 0, "byteOffset": 4, "byteLength": 5}],
        "accessors": [{)" + accessor + "}]}");
    return folder_ / "a.gltf";
  }
  GltfRows Read(const std::string& accessor) {
    const GltfFile file(Put(accessor));
    return GltfData(file).Numbers(0);
  }
  std::string Refusal(const std::string& accessor) {
    try {
      Read(accessor);
    } catch (const InputError& error) {
      return error.what();
    }
    return "was read";
  }
};

TEST_F(GltfDataTest, RowsByTypeOffsetAndStride) {
  const GltfRows pairs = Read(
      R"("bufferView": 0, "byteOffset": 1, "componentType": 5121, "count": 3, "type": "VEC2")");
  ASSERT_EQ(pairs.rows(), 3);
  EXPECT_EQ(pairs.row(2), Eigen::RowVector2d(5, 6));
  const GltfRows strided =
      Read(R"("bufferView": 1, "componentType": 5121, "count": 2, "type": "SCALAR")");
  EXPECT_EQ(strided, Eigen::Vector2d(4, 6));
  const GltfRows shorts =
      Read(R"("bufferView": 0, "componentType": 5123, "count": 2, "type": "SCALAR")");
  EXPECT_EQ(shorts, Eigen::Vector2d(256, 770));
  const GltfRows zeros = Read(R"("componentType": 5126, "count": 2, "type": "MAT4")");
  EXPECT_EQ(zeros, Eigen::MatrixXd::Zero(2, 16));
}

TEST_F(GltfDataTest, WhatTheFileDoesNotHaveIsSaid) {
  const std::string bytes = R"("componentType": 5121, "type": "SCALAR", )";
  EXPECT_THAT(Refusal(bytes + R"("bufferView": 0, "count": 9)"), HasSubstr("does not have"));
  EXPECT_THAT(Refusal(bytes + R"("bufferView": 0, "byteOffset": 8, "count": 1)"),
              HasSubstr("does not have"));
  EXPECT_THAT(Refusal(bytes + R"("bufferView": 2, "count": 1)"), HasSubstr("does not have"));
  EXPECT_THAT(Refusal(bytes + R"("bufferView": 3, "count": 1)"), HasSubstr("does not exist"));
  EXPECT_THAT(Refusal(bytes + R"("count": 900000000)"), HasSubstr("does not have"));
  EXPECT_THAT(Refusal(R"("bufferView": 0, "componentType": 5131, "type": "SCALAR", "count": 1)"),
              HasSubstr("componentType 5131"));
  EXPECT_THAT(Refusal(R"("bufferView": 0, "componentType": 5121, "type": "VEC9", "count": 1)"),
              HasSubstr("unknown kind"));
}

}  // namespace keypose::gltf_data_test
