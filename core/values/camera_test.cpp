#include "core/values/camera.h"

#include <gtest/gtest.h>

#include "core/values/errors.h"

namespace keypose::camera_test {

TEST(Camera, UnprojectInvertsProjectWithDistortion) {
  const Camera camera{800, 600, 700, 710, 401, 299, -0.12, 0.03, 1e-3, -5e-4};
  for (double x = -0.4; x <= 0.4; x += 0.2)
    for (double y = -0.3; y <= 0.3; y += 0.15) {
      const Eigen::Vector3d ray(x, y, 1);
      EXPECT_LT((camera.Unproject(camera.Project(2.5 * ray)) - ray).norm(), 1e-11);
    }
}

TEST(Camera, ScaledProjectsToScaledPixels) {
  const Camera camera{800, 600, 700, 710, 401, 299, -0.1, 0, 0, 0};
  const Eigen::Vector3d x(0.2, -0.1, 1.5);
  EXPECT_LT((camera.Scaled(0.5).Project(x) - 0.5 * camera.Project(x)).norm(), 1e-12);
}

TEST(Rigid3, ComposedWithInverseIsIdentity) {
  const Rigid3 pose{Eigen::Quaterniond(0.3, -0.2, 0.8, 0.1).normalized(), {1, 2, 3}};
  const Rigid3 identity = Compose(pose, pose.Inverse());
  EXPECT_LT(identity.translation.norm(), 1e-14);
  EXPECT_NEAR(std::abs(identity.rotation.w()), 1, 1e-14);
}

PointsX3 SomePoints() {
  PointsX3 points(5, 3);
  points << 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 3, 1, 1, 1;
  return points;
}

TEST(FitSimilarity, RecoversAKnownSimilarity) {
  Similarity3 truth;
  truth.scale = 2.5;
  truth.rotation =
      Eigen::AngleAxisd(2.9, Eigen::Vector3d(1, -2, 0.5).normalized()).toRotationMatrix();
  truth.translation = {3, -1, 7};
  const Similarity3 fit = FitSimilarity(SomePoints(), Transformed(truth, SomePoints()));
  EXPECT_NEAR(fit.scale, truth.scale, 1e-12);
  EXPECT_LT((fit.rotation - truth.rotation).norm(), 1e-12);
  EXPECT_LT((fit.translation - truth.translation).norm(), 1e-12);
}

TEST(FitSimilarity, MirroredPointsStillGiveARotation) {
  PointsX3 mirrored = SomePoints();
  mirrored.col(0) *= -1;
  EXPECT_NEAR(FitSimilarity(SomePoints(), mirrored).rotation.determinant(), 1, 1e-12);
}

TEST(FitSimilarity, TooFewOrCoincidentPointsThrowInputError) {
  EXPECT_THROW(FitSimilarity(SomePoints().topRows(2), SomePoints().topRows(2)), InputError);
  EXPECT_THROW(FitSimilarity(PointsX3::Ones(4, 3), SomePoints().topRows(4)), InputError);
}

}  // namespace keypose::camera_test
