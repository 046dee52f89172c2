#include "export/animation/animated_mesh.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/surfaces/shapes.h"
#include "core/values/errors.h"
#include "export/animation/testing/boxes.h"

namespace keypose::exporting::animated_mesh_test {

TEST(MakeAnimatedMesh, EveryCornerKeepsItsPositionAndTextureCoordinate) {
  const auto frames = StretchingBox(2);
  const AnimatedMesh mesh = MakeAnimatedMesh(frames, Names(2));
  EXPECT_EQ(mesh.uvs.rows(), 36);  // all corners differ in this layout
  for (int f = 0; f < frames[0].face_count(); ++f) {
    for (int k = 0; k < 3; ++k) {
      const int split = mesh.faces(f, k);
      EXPECT_EQ(mesh.points[1].row(split), frames[1].points.row(frames[1].faces(f, k)));
      EXPECT_EQ(mesh.uvs.row(split), frames[0].uvs.row(frames[0].uv_faces(f, k)));
    }
  }
}

TEST(MakeAnimatedMesh, EqualCoordinatesInDifferentRowsAreNotSplit) {
  Mesh box = UnwrappedBox();
  box.uvs.setConstant(0.5);
  EXPECT_EQ(MakeAnimatedMesh({box}, Names(1)).uvs.rows(), box.vertex_count());
}

TEST(MakeAnimatedMesh, VerticesThatCameDoubledAtASeamShareOneNormal) {
  // Two sides of a roof, whose ridge is doubled, as in a PLY with texture coordinates.
  Mesh roof;
  roof.points.resize(6, 3);
  roof.points << -1, 0, 0, 0, 0, 1, 0, 1, 1, 0, 0, 1, 1, 0, 0, 0, 1, 1;
  roof.faces.resize(2, 3);
  roof.faces << 0, 1, 2, 3, 4, 5;
  const AnimatedMesh mesh = MakeAnimatedMesh({roof}, Names(1));
  const auto normal = [&](int vertex) {
    const auto at = std::find(mesh.source_vertex.begin(), mesh.source_vertex.end(), vertex);
    return Eigen::RowVector3d(mesh.normals[0].row(at - mesh.source_vertex.begin()));
  };
  EXPECT_EQ(normal(1), normal(3));
  EXPECT_EQ(normal(2), normal(5));
  EXPECT_GT(std::abs(normal(1).dot(normal(0))), 0.1);
  EXPECT_NE(normal(1), normal(0)) << "the ridge is not shaded as one side";
}

TEST(MakeAnimatedMesh, SeamCopiesShareOneNormal) {
  const AnimatedMesh mesh = MakeAnimatedMesh(StretchingBox(1), Names(1));
  for (std::size_t a = 0; a < mesh.source_vertex.size(); ++a) {
    EXPECT_NEAR(mesh.normals[0].row(a).norm(), 1, 1e-12);
    for (std::size_t b = 0; b < a; ++b) {
      if (mesh.source_vertex[a] != mesh.source_vertex[b]) continue;
      EXPECT_EQ(mesh.normals[0].row(a), mesh.normals[0].row(b));
    }
  }
}

TEST(MakeAnimatedMesh, MeshWithoutTextureCoordinatesKeepsItsVertices) {
  const AnimatedMesh mesh = MakeAnimatedMesh({MakeIcosphere(2)}, Names(1));
  EXPECT_EQ(mesh.points[0].rows(), MakeIcosphere(2).vertex_count());
  EXPECT_EQ(mesh.uvs.rows(), 0);
}

void ExpectInputError(const std::vector<Mesh>& frames, const std::string& part) {
  try {
    MakeAnimatedMesh(frames, Names(frames.size()));
    FAIL() << "no error; expected one that says '" << part << "'";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), ::testing::HasSubstr(part));
  }
}

TEST(MakeAnimatedMesh, NoFramesThrowInputError) { ExpectInputError({}, "no frames"); }

TEST(MakeAnimatedMesh, OtherVertexCountThrowsInputErrorThatNamesTheFrame) {
  ExpectInputError({MakeIcosphere(1), MakeIcosphere(2)}, "frame_0001 has 162 vertices");
}

TEST(MakeAnimatedMesh, OtherFacesThrowInputErrorThatNamesTheFace) {
  auto frames = StretchingBox(3);
  std::swap(frames[2].faces(7, 0), frames[2].faces(7, 1));
  ExpectInputError(frames, "face 7 of frame_0002");
}

TEST(MakeAnimatedMesh, NanVertexThrowsInputErrorThatNamesTheFrame) {
  auto frames = StretchingBox(3);
  frames[1].points(4, 1) = NAN;
  ExpectInputError(frames, "frame_0001");
}

}  // namespace keypose::exporting::animated_mesh_test
