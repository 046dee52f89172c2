#include "motion/tracking/rig_checks.h"

#include <ceres/ceres.h>
#include <gtest/gtest.h>

#include <cmath>

#include "motion/tracking/testing/filmed_body.h"

namespace keypose::motion::rig_checks_test {

TEST(CheckAgreement, NamesTheCameraThatIsInMillimetres) {
  const BodyShape shape = AverageShape();
  std::vector<Silhouette> silhouettes = Filmed(Ring(6), shape, Standing());
  const Eigen::Quaterniond up = Eigen::Quaterniond::Identity();
  EXPECT_TRUE(CheckAgreement(silhouettes, up).against.empty());
  silhouettes[2].camera_from_world.translation *= 1000;
  silhouettes[2].center *= 1000;
  const RigAgreement agreement = CheckAgreement(silhouettes, up);
  EXPECT_EQ(agreement.against, std::vector<int>{2});
  EXPECT_TRUE(AgreesScaled(silhouettes, 2, 0.001, up));
  EXPECT_FALSE(AgreesScaled(silhouettes, 2, 1000, up));
}

TEST(CheckAgreement, CamerasThatDoNotOverlapAgreeOnNothing) {
  const BodyShape shape = AverageShape();
  std::vector<Silhouette> silhouettes = Filmed(Ring(2), shape, Standing());
  silhouettes[1].camera_from_world.translation += Eigen::Vector3d(0, 6, 0);
  silhouettes[1].center = silhouettes[1].camera_from_world.Inverse().translation;
  EXPECT_EQ(CheckAgreement(silhouettes, Eigen::Quaterniond::Identity()).hull.voxels, 0);
}

TEST(FindClockOffsets, FindsByHowManyFramesEachCameraIsLate) {
  const BodyShape shape = AverageShape();
  const std::vector<View> views = Ring(4);
  const std::vector<int> late{0, 2, 0, 1};
  std::vector<std::vector<OutlineRays>> rays(4);
  std::vector<Eigen::Vector3d> centers;
  for (const View& view : views) centers.push_back(view.Center());
  for (int f = 0; f < 24; ++f) {
    for (int c = 0; c < 4; ++c) {
      BodyPose pose = Standing();
      const double t = 0.25 * (f - late[c]);
      pose.q[2] += 0.12 * std::sin(t) + 0.05 * std::sin(2.7 * t),
          pose.q[0] += 0.2 * std::sin(0.6 * t);
      pose.q[Joints()[kShoulderL].first_dof + 1] -= 0.8 * std::sin(1.3 * t);
      rays[c].push_back(RaysOf(Filmed({views[c]}, shape, pose)[0]));
    }
  }
  const ClockOffsets clocks = FindClockOffsets(rays, centers, {0, 0, 0.9}, 4);
  EXPECT_EQ(clocks.frames, late);
  EXPECT_LT(clocks.after, 0.5 * clocks.before);
  // Without offsets, none are found.
  std::vector<std::vector<OutlineRays>> same(4);
  for (int c = 0; c < 4; ++c)
    for (int f = 0; f < 20; ++f) same[c].push_back(rays[c][f + late[c]]);
  EXPECT_EQ(FindClockOffsets(same, centers, {0, 0, 0.9}, 4).frames, (std::vector<int>{0, 0, 0, 0}));
}

}  // namespace keypose::motion::rig_checks_test
