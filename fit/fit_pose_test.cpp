// Which of several starts a pose is fitted from.
#include "fit/fit_pose.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "fit/testing/spotted_lump.h"

namespace keypose::fit::fit_pose_test {

class FitPoseStarts : public ::testing::Test {
 protected:
  FitPoseStarts() {
    for (const int i : {0, 2, 3, 6}) views_.push_back(PhotographOf(mesh_, texture_, rig_[i]));
  }
  /// The figure turned by an angle, and the rig's cameras that then took the photographs.
  Start On(double degrees, const std::vector<int>& rig_view) const {
    RigMotion motion;
    motion.rig_from_template.rotation =
        Eigen::AngleAxisd(degrees * M_PI / 180, Eigen::Vector3d::UnitZ());
    motion.rig_view = rig_view;
    std::vector<FoundCamera> cameras(views_.size());
    return {CamerasUnder(motion, rig_, cameras), motion};
  }
  FitInput Input() const { return {mesh_, texture_, stiffness_, views_, rig_, picks_, unplaced_}; }
  Attempt Fitted(const std::vector<Start>& starts) const {
    return FitPose(Input(), starts, nullptr);
  }
  /// Each photograph's true camera, found by itself, with matches all over the figure.
  std::vector<FoundCamera> TrueCameras() const {
    std::vector<FoundCamera> cameras;
    for (std::size_t k = 0; k < views_.size(); ++k) {
      const int i = std::array{0, 2, 3, 6}[k];
      FoundCamera camera;
      camera.found = true;
      camera.camera_from_world = rig_[i].camera_from_world;
      for (int v = 0; v < mesh_.vertex_count(); v += 7) {
        FeatureMatch match;
        match.point.vertices.setConstant(v);
        match.pixel =
            views_[k].camera().Project(camera.camera_from_world * mesh_.points.row(v).transpose());
        camera.matches.push_back(match);
      }
      camera.agreeing = camera.matches;
      camera.inliers = static_cast<int>(camera.matches.size());
      cameras.push_back(camera);
    }
    return cameras;
  }

  Mesh mesh_ = SpottedLump();
  Image8 texture_ = Spots();
  std::vector<View> rig_ = RingAround(mesh_, {0, 31, 75, 104, 158, 209, 251, 312});
  std::vector<PreparedView> views_;
  Eigen::VectorXd stiffness_;
  PosePicks picks_;
  Scene unplaced_;
};

TEST_F(FitPoseStarts, TheOneWhoseOutlinesAgreeIsTaken) {
  const Attempt attempt = Fitted({On(31, {1, 3, 4, 7}), On(0, {0, 2, 3, 6})});
  EXPECT_EQ(attempt.on_rig.value().rig_view, (std::vector<int>{0, 2, 3, 6}));
  EXPECT_GT(attempt.Overlap(), 0.97);
  EXPECT_LT((attempt.result.points - mesh_.points).rowwise().norm().mean(), 0.01);
}

TEST_F(FitPoseStarts, APhotographWithoutACameraCountsAgainstAStart) {
  texture_ = {};  // so no camera is found late
  const Attempt attempt = Fitted({On(0, {0, 2, -1, -1}), On(0, {0, 2, 3, 6})});
  EXPECT_EQ(attempt.on_rig.value().rig_view, (std::vector<int>{0, 2, 3, 6}));
  EXPECT_EQ(attempt.placed.size(), 4u);
}

TEST_F(FitPoseStarts, OneWithoutCamerasIsNotTaken) {
  texture_ = {};
  mesh_.points *= 1.8;  // so the outlines agree badly
  const Attempt attempt = Fitted({On(0, {0, -1, -1, -1}), On(0, {0, 2, 3, 6})});
  EXPECT_EQ(attempt.on_rig.value().rig_view, (std::vector<int>{0, 2, 3, 6}));
  EXPECT_EQ(Fitted({On(0, {0, -1, -1, -1})}).placed.size(), 1u);
}

TEST_F(FitPoseStarts, OnTheRigNoMotionIsTriedTwice) {
  const std::vector<int> truth{0, 2, 3, 6};
  const auto tries_it = [&](const std::vector<Start>& starts) {
    return std::any_of(starts.begin(), starts.end(), [&](const Start& start) {
      return start.on_rig && start.on_rig->rig_view == truth;
    });
  };
  EXPECT_TRUE(tries_it(StartsAround(Input(), TrueCameras(), {})));
  EXPECT_TRUE(tries_it(StartsAround(Input(), TrueCameras(), {On(31, {1, 3, 4, 7})})));
  EXPECT_FALSE(tries_it(StartsAround(Input(), TrueCameras(), {On(0, truth)})));
}

TEST_F(FitPoseStarts, FittedAgainAPhotographWithoutACameraGetsOne) {
  views_.resize(2);
  Attempt one;
  one.cameras = TrueCameras();
  one.cameras[1].found = false;
  one.result.points = mesh_.points;
  one.placed.push_back({views_[0], {}});
  one.result.view_quality.resize(1);
  one.result.view_quality[0].overlap = 0.98;
  const Attempt again = FitAgain(Input(), one, nullptr);
  EXPECT_EQ(again.placed.size(), 2u);
  EXPECT_GT(again.Agreement(), one.Agreement());
  EXPECT_LT((again.result.points - mesh_.points).rowwise().norm().mean(), 0.02);
}

TEST_F(FitPoseStarts, FittedAgainAnAttemptOnTheRigStays) {
  Attempt on_rig;
  on_rig.on_rig = RigMotion();
  on_rig.cameras = TrueCameras();
  on_rig.result.points = 1.5 * mesh_.points;
  const Attempt again = FitAgain(Input(), on_rig, nullptr);
  EXPECT_EQ(again.result.points, on_rig.result.points);
  EXPECT_EQ(FitAgain(Input(), Attempt(), nullptr).result.points.rows(), 0);
}

TEST(StartsOf, EachCameraByItselfOnlyWhereNoMotionIsClear) {
  const std::vector<FoundCamera> cameras(1);
  const std::vector<View> rig(1);
  RigMotion first, stayed;
  first.rig_view = stayed.rig_view = {0};
  first.clear = true;
  std::vector<Start> starts = StartsOf({first, stayed}, rig, cameras);
  ASSERT_EQ(starts.size(), 2u);
  EXPECT_TRUE(starts[0].on_rig && starts[1].on_rig);
  first.clear = false;
  starts = StartsOf({first, stayed}, rig, cameras);
  ASSERT_EQ(starts.size(), 2u);
  EXPECT_TRUE(starts[0].on_rig && !starts[1].on_rig);
  EXPECT_EQ(StartsOf({}, rig, cameras).size(), 1u);
}

}  // namespace keypose::fit::fit_pose_test
