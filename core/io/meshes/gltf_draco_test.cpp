#include "core/io/meshes/gltf_draco.h"

#include <draco/compression/encode.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>

namespace keypose::gltf_draco_test {

/// One triangle with positions and colours of bytes, unrounded.
std::string Packed(int* position, int* color) {
  draco::TriangleSoupMeshBuilder builder;
  builder.Start(1);
  const int p = builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32),
            c = builder.AddAttribute(draco::GeometryAttribute::COLOR, 3, draco::DT_UINT8);
  const std::array<std::array<float, 3>, 3> points = {{{0, 0, 0}, {2, 0, 0}, {0, 4, 0}}};
  const std::array<std::array<std::uint8_t, 3>, 3> colors = {
      {{255, 0, 0}, {0, 51, 0}, {0, 0, 102}}};
  builder.SetAttributeValuesForFace(p, draco::FaceIndex(0), points[0].data(), points[1].data(),
                                    points[2].data());
  builder.SetAttributeValuesForFace(c, draco::FaceIndex(0), colors[0].data(), colors[1].data(),
                                    colors[2].data());
  const std::unique_ptr<draco::Mesh> mesh = builder.Finalize();
  *position = static_cast<int>(mesh->attribute(p)->unique_id());
  *color = static_cast<int>(mesh->attribute(c)->unique_id());
  draco::Encoder encoder;
  encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, -1);
  draco::EncoderBuffer buffer;
  EXPECT_TRUE(encoder.EncodeMeshToBuffer(*mesh, &buffer).ok());
  return {buffer.data(), buffer.size()};
}

TEST(GltfDraco, AttributesAndCornersComeBack) {
  int position = -1, color = -1;
  const std::string bytes = Packed(&position, &color);
  DracoMesh mesh;
  ASSERT_EQ(UnpackDraco(bytes, {{"POSITION", position}, {"COLOR_0", color}},
                        {{"POSITION", false}, {"COLOR_0", true}}, &mesh),
            "");
  ASSERT_EQ(mesh.corners.rows(), 3);
  const DracoMesh::Rows &points = mesh.attributes.at("POSITION"),
                        &colors = mesh.attributes.at("COLOR_0");
  ASSERT_EQ(points.rows(), 3);
  ASSERT_EQ(colors.cols(), 3);
  for (Eigen::Index v = 0; v < 3; ++v) {
    const Eigen::RowVector3d p = points.row(v), c = colors.row(v);
    const Eigen::RowVector3d right(p.isZero() ? 1 : 0, p[0] / 10, p[1] / 10);
    EXPECT_LT((c - right).norm(), 1e-12);
  }
  EXPECT_EQ(points.sum(), 6);
}

TEST(GltfDraco, WhatCannotBeReadIsSaid) {
  int position = -1, color = -1;
  const std::string bytes = Packed(&position, &color);
  DracoMesh mesh;
  EXPECT_NE(UnpackDraco("no draco", {}, {}, &mesh), "");
  EXPECT_NE(UnpackDraco(bytes.substr(0, bytes.size() / 2), {}, {}, &mesh), "");
  EXPECT_EQ(UnpackDraco(bytes, {{"TEXCOORD_0", 77}}, {{"TEXCOORD_0", false}}, &mesh),
            "it has no attribute TEXCOORD_0");
}

}  // namespace keypose::gltf_draco_test
