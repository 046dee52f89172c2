#include "fit/limbs/limb_pictures.h"

#include <gtest/gtest.h>

#include "core/pictures/fit_view.h"
#include "fit/limbs/testing/bottle.h"

namespace keypose::fit::limb_pictures_test {

TEST(MakeSmallPicture, ShowsAPointAtTheSamePlace) {
  const Mesh mesh = MakeBottle();
  const View view = FitView(mesh.points, 30, 20, 400, 300);
  const PreparedView prepared =
      PrepareView(view, 0, Image8(400, 300, 3, 90), Image8(400, 300, 1, 255), 1, 2);
  const double size = view.camera.fx / view.camera_from_world.translation.norm();
  const SmallPicture small = MakeSmallPicture(prepared, view.camera_from_world, size / 2);
  EXPECT_EQ(small.mask.width, 200);
  EXPECT_EQ(small.mask.data[5000], 1);
  EXPECT_FLOAT_EQ(small.colors.data[5000], 90);
  const Eigen::Vector3d x(0.3, -0.2, 1.9);
  EXPECT_LT((2 * small.view.Project(x) - view.Project(x)).norm(), 1e-9);
}

}  // namespace keypose::fit::limb_pictures_test
