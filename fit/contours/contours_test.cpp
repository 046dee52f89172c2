#include "fit/contours/contours.h"

#include <gtest/gtest.h>

#include <numbers>

#include "core/surfaces/shapes.h"
#include "fit/contours/testing/disc_view.h"

namespace keypose::fit::contours_test {

TEST(FindSilhouette, OfASphereIsTheWholeCircleWithNormalsOutwards) {
  const std::vector<ContourPoint> contour = SphereSilhouette(DiscView(50));
  double length = 0;
  for (const ContourPoint& point : contour) {
    const Eigen::Vector2d from = point.pixel - Eigen::Vector2d::Constant(kMiddle);
    EXPECT_NEAR(from.norm(), SphereRadius(), 0.3);
    EXPECT_GT(point.normal.dot(from.normalized()), 0.5);
    length += point.length_px;
  }
  // A polyhedron's outline zigzags a little about the circle.
  EXPECT_NEAR(length, 2 * std::numbers::pi * SphereRadius(), 0.15 * length);
}

TEST(FindSilhouette, LeavesOutContoursBeforeTheSurfaceItself) {
  Mesh two = MakeIcosphere(4);
  const Mesh front = two;
  const int count = two.vertex_count();
  two.points.conservativeResize(2 * count, 3);
  two.points.bottomRows(count) = 0.3 * front.points;
  two.points.bottomRows(count).col(1).array() -= 3;  // a small sphere before the large one
  two.faces.conservativeResize(2 * front.face_count(), 3);
  two.faces.bottomRows(front.face_count()) = front.faces.array() + count;
  const PreparedView view = DiscView(50);
  for (const ContourPoint& point :
       FindSilhouette(two.points, two.faces, FindFacePairs(two.faces),
                      RayScene(two.points, two.faces), view.camera(), view.camera_from_world))
    EXPECT_LT(point.a, count);
}

}  // namespace keypose::fit::contours_test
