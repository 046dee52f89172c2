#include <gtest/gtest.h>

#include "core/io/meshes/mesh_io.h"
#include "core/io/meshes/ply_frames.h"
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

TEST_F(MeshIo, FramesAreTheMeshWithOtherPositionsAndNoNormals) {
  for (const bool colored : {true, false}) {
    Mesh mesh = ColoredSphereWithUvs();
    if (!colored) mesh.colors.resize(0, 3);
    mesh.normals = mesh.points.rowwise().normalized();
    PlyFrames frames(mesh);
    PlyFramesForOthers of_others(mesh);
    for (const double height : {0.25, -3.0}) {
      Mesh moved = mesh;
      moved.normals.resize(0, 3);
      moved.points.col(2).array() += height;
      frames.Write(folder_ / "frame.ply", moved.points);
      of_others.Write(folder_ / "other.ply", moved.points);
      WriteMesh(folder_ / "mesh.ply", moved);
      const std::string whole = ReadFile(folder_ / "mesh.ply");
      EXPECT_EQ(ReadFile(folder_ / "frame.ply"), whole);
      EXPECT_EQ(whole.size() - ReadFile(folder_ / "other.ply").size(),
                mesh.face_count() * 6 * sizeof(float) + 1)
          << "float in place of double";
      const Mesh other = ReadMesh(folder_ / "other.ply");
      EXPECT_EQ(other.points, moved.points);
      EXPECT_EQ(other.colors, moved.colors);
      EXPECT_EQ(other.faces, moved.faces);
    }
  }
}

}  // namespace keypose::mesh_write_test
