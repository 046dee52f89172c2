#include "motion/body/body_clip.h"

#include <gtest/gtest.h>

#include "core/io/meshes/bvh_io.h"
#include "core/values/angles.h"
#include "core/values/motion_clip.h"
#include "motion/body/body_pose.h"
#include "motion/body/testing/some_pose.h"

namespace keypose::motion::body_clip_test {

TEST(ClipOf, BvhHasTheJointsWhereTheTemplateHasThem) {
  const BodyShape shape = AverageShape();
  const std::vector<BodyPose> poses{SomePose(0), SomePose(1), SomePose(2)};
  const Eigen::Quaterniond up(Eigen::AngleAxisd(-kPi / 2, Eigen::Vector3d::UnitX()));
  const MotionClip clip = ParseBvh(BvhText(ClipOf(poses, shape, 0.04, up)), "clip");
  for (int f = 0; f < 3; ++f) {
    const std::vector<Rigid3> frames = JointFrames(clip, f);
    const PosedBody body = Posed(poses[f], shape);
    for (int j = 0; j < kJoints; ++j) {
      const int place = clip.Find(Joints()[j].name);
      ASSERT_GE(place, 0);
      // six decimals of a degree and of a metre, through a chain of six joints
      EXPECT_LT((frames[place].translation - up * body.position[j]).norm(), 1e-5)
          << Joints()[j].name;
    }
  }
}

}  // namespace keypose::motion::body_clip_test
