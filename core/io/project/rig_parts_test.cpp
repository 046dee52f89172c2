#include "core/io/project/rig_parts.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/values/errors.h"

namespace keypose::rig_parts_test {

TEST(ExactRotation, RoundedOnesBecomeExactAndOthersAreRefused) {
  const Eigen::Quaterniond q(Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()));
  const Eigen::Matrix3d rounded = (q.toRotationMatrix() * 1000).array().round().matrix() / 1000;
  const Eigen::Quaterniond exact = ExactRotation(rounded, "rig: a");
  EXPECT_NEAR(exact.norm(), 1, 1e-14);
  EXPECT_LT(exact.angularDistance(q), 2e-3);
  EXPECT_THROW(ExactRotation(2 * rounded, "rig: a"), InputError);
  EXPECT_THROW(ExactRotation(-rounded, "rig: a"), InputError);  // a mirror
}

TEST(RequireUsable, RefusesLensesAndPlacesThatCannotBe) {
  View view;
  view.camera = {640, 480, 500, 500, 320, 240, 0, 0, 0, 0};
  EXPECT_NO_THROW(RequireUsable(view, "rig: a"));
  View place = view;
  place.camera_from_world.translation.x() = std::nan("");
  EXPECT_THROW(RequireUsable(place, "rig: a"), InputError);
  View lens = view;
  lens.camera.fx = -1;
  EXPECT_THROW(RequireUsable(lens, "rig: a"), InputError);
}

TEST(SideOf, RoundsAndDoesNotWrap) {
  EXPECT_EQ(SideOf(1919.6), 1920);
  EXPECT_GT(SideOf(1e300), 1 << 20);
}

TEST(RigParts, AMatrixThatIsStoredByColumnsIsRefused) {
  const double rows[] = {500, 2, 320, 0, 510, 240, 0, 0, 1},
               columns[] = {500, 0, 0, 2, 510, 0, 320, 240, 1},
               scaled[] = {1000, 0, 640, 0, 1020, 480, 0, 0, 2};
  EXPECT_NO_THROW(RequireUpperTriangle(rows, "cam"));
  EXPECT_THROW(RequireUpperTriangle(columns, "cam"), InputError);
  EXPECT_THROW(RequireUpperTriangle(scaled, "cam"), InputError);
}

}  // namespace keypose::rig_parts_test
