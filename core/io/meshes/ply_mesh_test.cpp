#include "core/io/meshes/ply_mesh.h"

#include <gtest/gtest.h>

#include "core/io/meshes/mesh_io.h"
#include "core/io/testing/damaged_file.h"
#include "core/io/testing/mesh_files.h"

namespace keypose::ply_mesh_test {

namespace fs = std::filesystem;

TEST_F(HostileMesh, PlyFaceCornersThatAreNoVertexThrow) {
  const std::string head =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float "
      "z\n"
      "element face 1\nproperty list uchar float vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n";
  EXPECT_EQ(ReadMesh(Put("good.ply", head + "3 0 1 2\n")).face_count(), 1);
  for (const char* face : {"3 0 1 nan\n", "3 0 1 1e30\n", "3 0 1 -1\n", "3 0 1 clay\n"})
    MeshMessage(Put("bad.ply", head + face));
}

/// Both triangles of a unit square whose texture coordinates are its places.
void ExpectUvsAreThePlaces(const Mesh& mesh) {
  ASSERT_EQ(mesh.face_count(), 2);
  ASSERT_TRUE(mesh.has_uvs());
  for (int f = 0; f < 2; ++f)
    for (int k = 0; k < 3; ++k)
      EXPECT_EQ(mesh.uvs.row(mesh.uv_faces(f, k)), mesh.points.row(mesh.faces(f, k)).head(2));
}

const char* const kSquareFace = "element face 1\nproperty list uchar int vertex_indices\n";

TEST_F(MeshIo, TextureCoordinatesOfPlyVerticesAreReadAsBlenderAndMeshLabWriteThem) {
  for (const auto& [u, v] : {std::pair{"s", "t"}, {"texture_u", "texture_v"}})
    ExpectUvsAreThePlaces(ReadMesh(
        Put("m.ply", std::string("ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\n"
                                 "property float y\nproperty float z\nproperty float ") +
                         u + "\nproperty float " + v + "\n" + kSquareFace +
                         "end_header\n0 0 5 0 0\n1 0 5 1 0\n1 1 5 1 1\n0 1 5 0 1\n4 0 1 2 3\n")));
}

TEST_F(MeshIo, QuadsOfAPlyKeepTheTextureCoordinatesOfTheirCorners) {
  ExpectUvsAreThePlaces(ReadMesh(
      Put("m.ply", std::string("ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\n"
                               "property float y\nproperty float z\n") +
                       kSquareFace +
                       "property list uchar float texcoord\nend_header\n"
                       "0 0 5\n1 0 5\n1 1 5\n0 1 5\n4 0 1 2 3 8 0 0 1 0 1 1 0 1\n")));
}

}  // namespace keypose::ply_mesh_test
