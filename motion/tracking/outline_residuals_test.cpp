#include "motion/tracking/outline_residuals.h"

#include <ceres/ceres.h>
#include <gtest/gtest.h>

#include <cmath>

#include "motion/tracking/testing/filmed_body.h"

namespace keypose::motion::outline_residuals_test {

TEST(OutlineMatches, ResidualsHaveTheSlopesThatTheyClaim) {
  const BodyShape shape = AverageShape();
  const std::vector<View> views = Ring(3);
  const std::vector<Silhouette> silhouettes = Filmed(views, shape, Standing());
  BodyPose pose = Standing();
  pose.q.array() += 0.02;
  const LocalSurface surface = SurfaceOf(shape);
  const ViewMatches matches = FindMatches(silhouettes[0], surface, Posed(pose, shape), 20);
  ASSERT_GT(matches.samples.size(), 100u);
  ASSERT_GT(matches.pulls.size(), 100u);
  // The pulls are smooth; the distance field is only piecewise so.
  VisitResiduals(silhouettes[0], ViewMatches{matches.samples, matches.pulls, 0}, Posed(pose, shape),
                 [&](const OutlineResidual& r) {
                   for (int k = 0; k < 3; ++k) {
                     const Eigen::Vector3d step = 1e-6 * Eigen::Vector3d::Unit(k);
                     const Eigen::Vector2d move =
                         (silhouettes[0].Project(r.x + step) - silhouettes[0].Project(r.x - step)) /
                         2e-6;
                     // Pull is n^T d(pixel)/d(x): its size cannot exceed the pixel's own motion.
                     EXPECT_LE(std::abs(r.pull[k]), 1.2 * move.norm() + 1e-6);
                   }
                 });
  const Eigen::Vector3d x(0.2, -0.1, 1.1);
  const Eigen::Vector2d n(0.6, -0.8);
  const Eigen::Vector3d pull = silhouettes[0].Pull(x, n);
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector3d step = 1e-6 * Eigen::Vector3d::Unit(k);
    const double slope =
        n.dot(silhouettes[0].Project(x + step) - silhouettes[0].Project(x - step)) / 2e-6;
    EXPECT_NEAR(pull[k], slope, 1e-4 * pull.norm());
  }
}

}  // namespace keypose::motion::outline_residuals_test
