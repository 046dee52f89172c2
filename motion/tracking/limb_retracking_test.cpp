#include "motion/tracking/limb_retracking.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/numbers/parallel.h"
#include "core/pictures/render.h"
#include "core/surfaces/ray_scene.h"
#include "core/values/angles.h"

namespace keypose::motion::limb_retracking_test {

constexpr int kSide = 280, kCount = 12;

// Six cameras around the template, with masks by ray casting.
std::vector<Silhouette> Filmed(const BodyShape& shape, const BodyPose& pose) {
  const Mesh mesh{BodyPoints(SurfaceOf(shape), Posed(pose, shape)), BodyFaces(), {}, {}, {}, {}};
  const RayScene scene(mesh.points, mesh.faces);
  std::vector<Silhouette> silhouettes;
  for (int v = 0; v < 6; ++v) {
    View view;
    view.camera = {kSide, kSide, 1.45 * kSide, 1.45 * kSide, kSide / 2.0, kSide / 2.0, 0, 0, 0, 0};
    const double azimuth = kPi / 3 * v + 0.1;
    view.camera_from_world =
        LookAt({4 * std::cos(azimuth), 4 * std::sin(azimuth), 0.8 + 0.7 * (v % 3)}, {0, 0, 0.9});
    const Raster raster = Rasterize(mesh, scene, view);
    Image8 mask(kSide, kSide, 1);
    for (std::size_t i = 0; i < mask.data.size(); ++i)
      mask.data[i] = raster.face.data[i] >= 0 ? 255 : 0;
    const SilhouetteCamera camera(view, 1);
    silhouettes.push_back(MakeSilhouette(camera, v, camera.Reduced(mask), 220));
  }
  return silhouettes;
}

/// The left arm sinks and bends, a little in each frame.
BodyPose TruePose(int frame) {
  BodyPose pose;
  pose.q.head<3>() = Eigen::Vector3d(0.05, -0.03, 0.93);
  const int left = Joints()[kShoulderL].first_dof, right = Joints()[kShoulderR].first_dof;
  pose.q[left + 1] = 0.3 + 0.05 * frame, pose.q[left + 3] = 0.3 + 0.06 * frame;
  pose.q[right + 1] = -0.6, pose.q[right + 3] = 0.3;
  pose.q[Joints()[kHipL].first_dof + 1] = -0.2, pose.q[Joints()[kHipR].first_dof + 1] = 0.2;
  return pose;
}

/// The same arm, aside by about 20 cm.
BodyPose WrongPose(int frame) {
  BodyPose pose = TruePose(frame);
  pose.q[Joints()[kShoulderL].first_dof + 2] += 0.7;
  return pose;
}

struct Take {
  BodyShape shape = AverageShape();
  std::vector<std::vector<Silhouette>> films;
  std::vector<TrackedFrame> frames;

  /// The poses as they would be tracked, the masks of the true ones.
  template <class PoseAt>
  explicit Take(PoseAt&& tracked, bool arm_jumps = false) {
    PoseOptions as_it_is;
    as_it_is.rounds = 1, as_it_is.steps = 0;
    for (int f = 0; f < kCount; ++f) {
      films.push_back(Filmed(shape, arm_jumps && f >= 6 ? WrongPose(f) : TruePose(f)));
      frames.push_back(
          FrameOf(SolvePose(films[f], shape, SurfaceOf(shape), tracked(f), as_it_is), shape));
      frames[f].coverage = CoverageOf(films[f], SurfaceOf(shape), Posed(frames[f].pose, shape));
    }
  }
  Retracking Retrack() {
    return RetrackLimbs(
        shape, [&](int f) -> const std::vector<Silhouette>& { return films[f]; }, &frames);
  }
  double WristOff(int f, const BodyPose& from) const {
    return (Posed(frames[f].pose, shape).position[kWristL] - Posed(from, shape).position[kWristL])
        .norm();
  }
};

bool IsWrong(int frame) { return frame >= 3 && frame < 9; }
BodyPose WrongInBetween(int frame) { return IsWrong(frame) ? WrongPose(frame) : TruePose(frame); }

TEST(RetrackLimbs, AnArmThatWasFollowedBesideTheFilmedOneIsSetRight) {
  Take take(WrongInBetween);
  ASSERT_GT(take.WristOff(5, TruePose(5)), 0.15);
  const Retracking retracking = take.Retrack();
  EXPECT_EQ(retracking.changed, 6);
  for (int f = 0; f < kCount; ++f) EXPECT_LT(take.WristOff(f, TruePose(f)), 0.03) << f;
}

TEST(RetrackLimbs, AWrongCourseUpToTheLastFrameIsSetRightFromItsBegin) {
  Take take([](int f) { return f >= 6 ? WrongPose(f) : TruePose(f); });
  EXPECT_EQ(take.Retrack().changed, 6);
  for (int f = 0; f < kCount; ++f) EXPECT_LT(take.WristOff(f, TruePose(f)), 0.03) << f;
}

TEST(RetrackLimbs, AnArmThatIsBesideTheFilmedOneAllAlongIsFound) {
  Take take(WrongPose);
  const Retracking retracking = take.Retrack();
  EXPECT_EQ(retracking.changed, kCount);
  for (int f = 0; f < kCount; ++f) EXPECT_LT(take.WristOff(f, TruePose(f)), 0.03) << f;
}

TEST(RetrackLimbs, AJumpThatWasFilmedStays) {
  const auto jumps = [](int f) { return f >= 6 ? WrongPose(f) : TruePose(f); };
  Take take(jumps, true);
  const Retracking retracking = take.Retrack();
  EXPECT_GT(retracking.solved, 0);  // it was tracked again
  EXPECT_EQ(retracking.changed, 0);
  for (int f = 0; f < kCount; ++f) EXPECT_LT(take.WristOff(f, jumps(f)), 1e-12) << f;
}

TEST(RetrackLimbs, NothingChangesWhereAllIsRight) {
  Take take(TruePose);
  EXPECT_EQ(take.Retrack().changed, 0);
  take.frames.resize(2);
  EXPECT_EQ(take.Retrack().solved, 0);
  take.frames.clear();
  EXPECT_EQ(take.Retrack().changed, 0);
}

TEST(RetrackLimbs, SameBitsForAnyThreadCount) {
  Take one(WrongInBetween);
  Take three = one;
  SetThreadCount(1);
  one.Retrack();
  SetThreadCount(3);
  three.Retrack();
  SetThreadCount(0);
  for (int f = 0; f < kCount; ++f) EXPECT_EQ(one.frames[f].pose.q, three.frames[f].pose.q);
}

}  // namespace keypose::motion::limb_retracking_test
