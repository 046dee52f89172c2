#include <gtest/gtest.h>

#include "core/io/meshes/mesh_io.h"
#include "core/io/testing/mesh_files.h"
#include "core/io/text/files.h"

namespace keypose::mesh_write_test {

TEST_F(MeshIo, ObjKeepsPositionsUvsAndNamesItsMaterial) {
  const Mesh mesh = ColoredSphereWithUvs();
  WriteMesh(folder_ / "m.obj", mesh, "texture.png");
  const Mesh read = ReadMesh(folder_ / "m.obj");
  // The OBJ parser rounds decimals itself and may miss the last bits.
  EXPECT_LT((read.points - mesh.points).cwiseAbs().maxCoeff(), 1e-14);
  EXPECT_EQ(read.faces, mesh.faces);
  EXPECT_EQ(read.uv_faces, mesh.uv_faces);
  EXPECT_LT((read.uvs - mesh.uvs).cwiseAbs().maxCoeff(), 1e-14);
  EXPECT_NE(ReadFile(folder_ / "m.mtl").find("map_Kd texture.png"), std::string::npos);
}

TEST_F(MeshIo, ObjKeepsColoursOfItsVertices) {
  const ColorsX3 expected = (ColorsX3(3, 3) << 255, 0, 51, 0, 255, 0, 0, 0, 255).finished();
  EXPECT_EQ(
      ReadMesh(Put("m.obj", "v 0 0 0 1 0 0.2\nv 1 0 0 0 1.0 0\nv 0 1 0 0 0 1\nf 1 2 3\n")).colors,
      expected);
  EXPECT_EQ(ReadMesh(Put("m.obj",
                         "v 0 0 0 255 0 51\r\nv 1 0 0 0 255 0\r\nv 0 1 0 0 0 255\r\nf 1 2 3\r\n"))
                .colors,
            expected);
  EXPECT_EQ(ReadMesh(Put("m.obj", "v 0 0 0 1\nv 1 0 0 1\nv 0 1 0 1\nf 1 2 3\n")).colors.rows(), 0)
      << "a fourth coordinate is no colour";
}

}  // namespace keypose::mesh_write_test
