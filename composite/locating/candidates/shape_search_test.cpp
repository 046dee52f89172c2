// From which side a matte shows a mesh.
#include <gtest/gtest.h>

#include "composite/locating/candidates/shape_search.h"
#include "composite/locating/testing/odd_body.h"

namespace keypose::composite::shape_search_test {

TEST(ShapeSearch, FindsTheSideThatAMatteShows) {
  const Mesh body = OddBody();
  const Figure figure(body.points, body.faces);
  Placement truth = LookingFrom(70, 15);
  truth.camera = truth.camera.Scaled(0.375);
  const Image8 matte = Covered(figure, truth);
  const ShapeSearch search(figure, AngularRadius(truth.camera, matte));
  const std::vector<ShapeCandidate> found = search.Find(truth.camera, matte, 10);
  ASSERT_FALSE(found.empty());
  EXPECT_LT(TurnBetween({truth.camera, found[0].camera_from_mesh}, truth), 12);
  EXPECT_GT(found[0].overlap, 0.85);
  const Eigen::Vector3d off =
      found[0].camera_from_mesh * figure.center - truth.camera_from_mesh * figure.center;
  EXPECT_LT(off.norm(), 0.05 * 0.55);
  EXPECT_TRUE(search.Find(truth.camera, Image8(240, 180, 1), 10).empty());
}

}  // namespace keypose::composite::shape_search_test
