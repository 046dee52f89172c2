// A folder for files of meshes, and a mesh with all that they can hold.
#pragma once

#include <gtest/gtest.h>

#include "core/surfaces/geometry.h"
#include "core/surfaces/shapes.h"
#include "core/testing/folder.h"

namespace keypose {

inline Mesh ColoredSphereWithUvs() {
  Mesh mesh = MakeIcosphere(2);
  mesh.normals = VertexNormals(mesh.points, mesh.faces);
  mesh.colors = ColorsX3::Constant(mesh.points.rows(), 3, 77);
  mesh.uvs = (mesh.points.leftCols(2).array() * 0.5 + 0.5).matrix();
  mesh.uv_faces = mesh.faces;
  return mesh;
}

class MeshIo : public ::testing::Test, public TestingFolder {};

}  // namespace keypose
