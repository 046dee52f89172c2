#include "core/surfaces/mesh_binding.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/surfaces/geometry.h"
#include "core/surfaces/shapes.h"
#include "core/values/errors.h"

namespace keypose::mesh_binding_test {

TEST(NumberingHash, IsOfTheFacesAlone) {
  const Mesh ball = MakeIcosphere(2);
  Mesh posed = ball;
  posed.points.col(2) *= 2;
  EXPECT_EQ(NumberingHash(posed), NumberingHash(ball));
  EXPECT_NE(GeometryHash(posed), GeometryHash(ball));
  posed.faces.row(0).swap(posed.faces.row(1));
  EXPECT_NE(NumberingHash(posed), NumberingHash(ball));
}

TEST(SurfacePlaces, PlaceOnABallHasItsPositionNormalAndColour) {
  Mesh ball = MakeIcosphere(4);
  ball.colors = ColorsX3::Constant(ball.points.rows(), 3, 90);
  const SurfacePlaces places(ball);
  const SurfacePlace place = places.At(7, {0.5, 0.25, 0.25});
  const Eigen::Vector3d wanted = 0.5 * ball.points.row(ball.faces(7, 0)) +
                                 0.25 * ball.points.row(ball.faces(7, 1)) +
                                 0.25 * ball.points.row(ball.faces(7, 2));
  EXPECT_LT((place.position - wanted).norm(), 1e-15);
  EXPECT_GT(place.normal.dot(wanted.normalized()), 0.999);
  ASSERT_TRUE(place.color);
  EXPECT_LT((*place.color - Eigen::Vector3d::Constant(90)).norm(), 1e-9);
}

TEST(SurfacePlaces, WithoutColoursThereIsNoneAndWithoutFacesItThrows) {
  const Mesh ball = MakeIcosphere(2);
  EXPECT_FALSE(SurfacePlaces(ball).At(0, {1, 0, 0}).color);
  EXPECT_THROW(SurfacePlaces{Mesh()}, InputError);
}

TEST(BindTo, SamplesLieOnTheMeshAndAreTheSameEachTime) {
  const Mesh box = MakeBox(1, 1, 1);
  const MeshBinding binding = BindTo(box), again = BindTo(box);
  EXPECT_TRUE(binding.known());
  EXPECT_EQ(binding.vertex_count, 8);
  EXPECT_EQ(binding.face_count, 12);
  EXPECT_NEAR(binding.diagonal, std::sqrt(3), 1e-12);
  EXPECT_EQ(binding.points, again.points);
  ASSERT_GT(binding.points.rows(), 100);
  for (Eigen::Index s = 0; s < binding.points.rows(); ++s) {
    const Eigen::Array3d p = binding.points.row(s).transpose();
    EXPECT_LT((p.min(1 - p)).abs().minCoeff(), 1e-6) << s;
  }
}

}  // namespace keypose::mesh_binding_test
