#include "core/surfaces/face_net.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/values/errors.h"

namespace keypose::face_net_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// A quad and a triangle beside it; the quad begins at vertex 3.
struct Roof {
  Roof() {
    mesh.points = PointsX3::Zero(5, 3);
    mesh.faces.resize(3, 3);
    mesh.faces << 3, 0, 1, 3, 1, 2, 1, 4, 2;
    polygons = {{4, 3}, {3, 0, 1, 2, 1, 4, 2}};
  }
  void GiveUvs() {
    mesh.uvs.resize(6, 2);
    mesh.uvs << 0, 0, 1, 0, 1, 1, 0, 1, 2, 0, 1, 0;
    mesh.uv_faces.resize(3, 3);
    mesh.uv_faces << 3, 0, 1, 3, 5, 2, 1, 4, 2;  // 5 lies where 1 does
  }
  std::string Refusal() const {
    try {
      NetOf(mesh, polygons);
    } catch (const InputError& error) {
      return error.what();
    }
    return "was taken";
  }
  Mesh mesh;
  Polygons polygons;
};

TEST(NetOf, PolygonsKeepFirstCornerWindingAndTextureCorners) {
  Roof roof;
  EXPECT_THAT(NetOf(roof.mesh, roof.polygons).uvs, IsEmpty());
  roof.GiveUvs();
  const FaceNet net = NetOf(roof.mesh, roof.polygons);
  EXPECT_THAT(net.sizes, ElementsAre(4, 3));
  EXPECT_THAT(net.vertices, ElementsAre(3, 0, 1, 2, 1, 4, 2));
  EXPECT_THAT(net.uvs, ElementsAre(3, 0, 1, 2, 1, 4, 2));
  EXPECT_EQ(net.taken_apart, 0);
}

TEST(NetOf, WithoutPolygonsTrianglesAreTheFaces) {
  Roof roof;
  roof.GiveUvs();
  const FaceNet net = NetOf(roof.mesh, {});
  EXPECT_THAT(net.sizes, ElementsAre(3, 3, 3));
  EXPECT_THAT(net.vertices, ElementsAre(3, 0, 1, 3, 1, 2, 1, 4, 2));
  EXPECT_THAT(net.uvs, ElementsAre(3, 0, 1, 3, 5, 2, 1, 4, 2));
}

TEST(NetOf, ASeamThroughAPolygonTakesItApart) {
  Roof roof;
  roof.GiveUvs();
  roof.mesh.uvs.row(5) << 0.5, 0.5;
  const FaceNet net = NetOf(roof.mesh, roof.polygons);
  EXPECT_EQ(net.taken_apart, 1);
  EXPECT_THAT(net.sizes, ElementsAre(3, 3, 3));
  EXPECT_THAT(net.uvs, ElementsAre(3, 0, 1, 3, 5, 2, 1, 4, 2));
}

TEST(NetOf, AVertexThatComesTwiceTakesAPolygonApart) {
  Roof roof;
  roof.mesh.faces.row(1) << 3, 1, 0;
  roof.polygons.corners = {3, 0, 1, 0, 1, 4, 2};
  EXPECT_EQ(NetOf(roof.mesh, roof.polygons).taken_apart, 1);
}

TEST(NetOf, ATriangleBeginsWhereItDidInItsFile) {
  Roof roof;
  roof.GiveUvs();
  roof.polygons.corners = {3, 0, 1, 2, 4, 2, 1};
  const FaceNet net = NetOf(roof.mesh, roof.polygons);
  EXPECT_THAT(net.vertices, ElementsAre(3, 0, 1, 2, 4, 2, 1));
  EXPECT_THAT(net.uvs, ElementsAre(3, 0, 1, 2, 4, 2, 1));
}

TEST(NetOf, PolygonsOfAnotherMeshAreRefused) {
  Roof roof;
  roof.polygons.corners = {3, 0, 1, 4, 1, 4, 2};
  EXPECT_THAT(roof.Refusal(), HasSubstr("number 0 (from 0) has other corners"));
  roof.polygons.corners = {3, 2, 1, 0, 1, 4, 2};
  EXPECT_THAT(roof.Refusal(), HasSubstr("number 0")) << "the other way round";
  roof.polygons.corners = {3, 0, 2, 1, 1, 4, 2};
  EXPECT_THAT(roof.Refusal(), HasSubstr("number 0")) << "edges that no triangle has";
  roof.polygons.corners = {3, 0, 1, 2, 1, 2, 4};
  EXPECT_THAT(roof.Refusal(), HasSubstr("number 1"));
  roof.polygons = {{4}, {3, 0, 1, 2}};
  EXPECT_THAT(roof.Refusal(), HasSubstr("they are 2 triangles, and the mesh has 3"));
}

}  // namespace keypose::face_net_test
