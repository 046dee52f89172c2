// Which of several starts a pose is fitted from.
#include "fit/fit_pose.h"

#include <gtest/gtest.h>

#include "fit/testing/spotted_lump.h"

namespace keypose::fit {
namespace {

class FitPoseStarts : public testing::Test {
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
  Attempt Fitted(const std::vector<Start>& starts) const {
    return FitPose({mesh_, texture_, stiffness_, views_, rig_, picks_, unplaced_}, starts, nullptr);
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

}  // namespace
}  // namespace keypose::fit
