#include "interpolate/sequence.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <string_view>
#include <vector>

#include "core/surfaces/shapes.h"
#include "core/values/camera.h"
#include "core/values/errors.h"
#include "interpolate/testing/played_poses.h"

namespace keypose::interpolation::sequence_test {

TEST(StreamFrames, KeysComeOutWithTheirOwnBitsWhateverTheMethod) {
  const Poses p;
  for (const Method method :
       {Method::kArap, Method::kPaper, Method::kLinear, Method::kVolumetric}) {
    const Schedule schedule = MakeSchedule({3, 0});
    const Shown shown = Play(p.all(), p.mesh.faces, schedule, method);
    ASSERT_EQ(shown.points.size(), 6u);
    EXPECT_EQ(schedule.key_frames, (std::vector<int>{0, 4, 5}));
    EXPECT_EQ(shown.points[0], p.a);
    EXPECT_EQ(shown.points[4], p.b);
    EXPECT_EQ(shown.points[5], p.c);
    EXPECT_NE(shown.points[2], p.b);
  }
}

TEST(StreamFrames, HoldsStepsAndTwosRepeatBits) {
  const Poses p;
  Timeline timeline = At({0, 1, 2, 3});
  timeline.keys[0].step = 2;
  timeline.keys[1].hold_s = 0.4;
  timeline.keys[2].travel = Travel::kStepped;
  timeline.keys[3].hold_s = 0.2;
  const Shown shown = Play({p.a, p.b, p.c, p.a}, p.mesh.faces, ScheduleOf(timeline));
  ASSERT_EQ(shown.points.size(), 33u);
  EXPECT_EQ(shown.points[1], p.a);  // on twos: 0 0 2 2 ...
  EXPECT_EQ(shown.points[3], shown.points[2]);
  EXPECT_NE(shown.points[4], shown.points[3]);
  EXPECT_EQ(shown.points[9], shown.points[8]);
  for (int f = 10; f <= 14; ++f) EXPECT_EQ(shown.points[f], p.b);  // held
  EXPECT_NE(shown.points[15], p.b);
  for (int f = 20; f <= 29; ++f) EXPECT_EQ(shown.points[f], p.c);  // stepped
  for (int f = 30; f <= 32; ++f) EXPECT_EQ(shown.points[f], p.a);
  EXPECT_EQ(shown.distortion.segments[2].in_betweens, 0);
  EXPECT_EQ(shown.distortion.frames[3].same_as, 2);
}

TEST(StreamFrames, StopsWhenAskedTo) {
  class Stopper : public Progress {
   public:
    void Update(double fraction, std::string_view) override { fraction_ = fraction; }
    bool cancelled() const override { return fraction_ > 0.5; }
    double fraction_ = 0;
  } stopper;
  const Poses p;
  const Schedule schedule = MakeSchedule({20, 20});
  const auto source =
      MakeFrameSource(p.all(), p.mesh.faces, schedule, Method::kLinear, PlainRules(schedule, true));
  int taken = 0;
  EXPECT_THROW(StreamFrames(
                   p.all(), schedule, *source, [&](const FrameView&) { ++taken; }, &stopper),
               Cancelled);
  EXPECT_GT(taken, 15);
  EXPECT_LT(taken, 30);
}

TEST(MakeFrameSource, RefusesKeysThatDoNotFit) {
  const Poses p;
  const Schedule two = MakeSchedule({3}), three = MakeSchedule({3, 3});
  const auto make = [&](const std::vector<PointsX3>& keys, const Schedule& schedule) {
    return MakeFrameSource(keys, p.mesh.faces, schedule, Method::kArap, PlainRules(schedule, true));
  };
  EXPECT_THROW(make({p.a}, two), InputError);
  EXPECT_THROW(make({p.a, p.b}, three), InputError);
  EXPECT_THROW(make({p.a, p.b.topRows(5)}, two), InputError);
  PointsX3 nan = p.b;
  nan(3, 1) = std::nan("");
  EXPECT_THROW(make({p.a, nan}, two), InputError);
  Timeline loop = At({0, 1});
  loop.loop = true;
  EXPECT_THROW(make({p.a, p.b}, ScheduleOf(loop)), InputError);
}

TEST(AlignedKeys, UndoesTheMotionItMayUndo) {
  const Mesh mesh = MakeBox(1, 2, 3);
  Similarity3 yaw, any;
  yaw.rotation = Eigen::AngleAxisd(0.8, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  yaw.translation << 1, 2, 0;
  any.rotation = Eigen::AngleAxisd(0.8, Eigen::Vector3d(1, 1, 1).normalized()).toRotationMatrix();
  any.scale = 1.3;
  const PointsX3 moved = Transformed(any, mesh.points);
  EXPECT_LT(Gap(AlignedKeys({mesh.points, Transformed(yaw, mesh.points)}, AlignKeys::kUpright)[1],
                mesh.points),
            1e-12);
  EXPECT_LT(Gap(AlignedKeys({mesh.points, moved}, AlignKeys::kSimilarity)[1], mesh.points), 1e-12);
  EXPECT_GT(Gap(AlignedKeys({mesh.points, moved}, AlignKeys::kRigid)[1], mesh.points), 0.05);
  EXPECT_EQ(AlignedKeys({mesh.points, moved}, AlignKeys::kNone)[1], moved);
  const auto again = AlignedKeys({mesh.points, moved, mesh.points, moved}, AlignKeys::kRigid);
  EXPECT_EQ(again[2], mesh.points);
  EXPECT_EQ(again[3], again[1]);
}

TEST(AlignedKeys, UprightLeavesEachPoseOnItsGround) {
  const Mesh mesh = MakeBox(1, 2, 3);
  PointsX3 crouched = mesh.points;
  crouched.col(2) *= 0.6;
  crouched.col(0).array() += 0.4;
  const PointsX3 aligned = AlignedKeys({mesh.points, crouched}, AlignKeys::kUpright)[1];
  EXPECT_EQ(aligned.col(2).minCoeff(), 0);
  EXPECT_NEAR(aligned.col(2).maxCoeff(), 1.8, 1e-12);
  EXPECT_NEAR(aligned.col(0).mean(), mesh.points.col(0).mean(), 1e-12);
}

TEST(SameSized, ABentPoseOfAnotherSizeGetsTheFirstOnesSize) {
  const Mesh mesh = MakeIcosphere(4);
  PointsX3 bent = mesh.points;
  for (Eigen::Index v = 0; v < bent.rows(); ++v)
    if (bent(v, 2) > 0.8) bent.row(v) *= 1.2;  // a part that really grew
  const PointsX3 larger = 1.047 * bent;
  const auto sized = SameSized({mesh.points, larger, mesh.points}, mesh.faces);
  EXPECT_EQ(sized[0], mesh.points);
  EXPECT_LT((sized[1] - bent).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_EQ(sized[2], mesh.points);
}

}  // namespace keypose::interpolation::sequence_test
