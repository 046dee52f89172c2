// The motions of a figure on the rig that matches speak for.
#include "fit/cameras/rig_motions.h"

#include <gtest/gtest.h>

#include "fit/testing/spotted_lump.h"

namespace keypose::fit::rig_motions_test {

/// About a horizontal axis through the middle.
Rigid3 Tilted(double degrees) {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(degrees * M_PI / 180, Eigen::Vector3d::UnitX())),
          Eigen::Vector3d::Zero()};
}

/// A photograph whose camera alone matters.
PreparedView Blank(const View& view) {
  Image8 mask(view.camera.width, view.camera.height, 1);
  std::fill(mask.data.begin(), mask.data.end(), 255);
  return PrepareView(view, 0, Image8(mask.width, mask.height, 3), mask, 1, 1);
}

class RigMotions : public ::testing::Test {
 protected:
  /// Adds a photograph from a camera of the rig, with matches on the halves of the figure, which
  /// moved; its own camera follows one of them.
  void Add(int of_rig, const Rigid3& above, int matches_above, const Rigid3& below,
           int matches_below) {
    const View& view = rig_[of_rig];
    views_.push_back(Blank(view));
    FoundCamera camera;
    camera.found = true;
    camera.inliers = std::max(matches_above, matches_below);
    const Rigid3& half = matches_above > matches_below ? above : below;
    camera.camera_from_world = Compose(view.camera_from_world, half);
    for (int v = 0, a = 0, b = 0; v < mesh_.vertex_count(); v += 7) {
      const Eigen::Vector3d x = mesh_.points.row(v);
      const bool upper = x.z() > 0;
      if (upper ? a >= matches_above : b >= matches_below) continue;
      ++(upper ? a : b);
      FeatureMatch match;
      match.point.vertices.setConstant(v);
      match.pixel =
          views_.back().camera().Project(view.camera_from_world * ((upper ? above : below) * x));
      camera.matches.push_back(match);
    }
    cameras_.push_back(camera);
  }
  std::vector<RigMotion> Found() const { return FindRigMotions(mesh_, cameras_, views_, rig_); }
  static double Degrees(const RigMotion& motion) {
    return Eigen::Quaterniond::Identity().angularDistance(motion.rig_from_template.rotation) * 180 /
           M_PI;
  }

  Mesh mesh_ = SpottedLump();
  std::vector<View> rig_ = RingAround(mesh_, {0, 31, 75, 104, 158, 209, 251, 312});
  std::vector<PreparedView> views_;
  std::vector<FoundCamera> cameras_;
};

TEST_F(RigMotions, AFigureThatStayedHasOneMotion) {
  for (const int i : {5, 0, 2, 7}) Add(i, Rigid3(), 40, Rigid3(), 30);
  const std::vector<RigMotion> found = Found();
  ASSERT_EQ(found.size(), 1u);
  EXPECT_TRUE(found[0].clear);
  EXPECT_LT(Degrees(found[0]), 0.01);
  EXPECT_EQ(found[0].rig_view, (std::vector<int>{5, 0, 2, 7}));
}

TEST_F(RigMotions, AFigureThatTurnedHasItsMotionFirst) {
  const Rigid3 turned{Eigen::Quaterniond(Eigen::AngleAxisd(0.6, Eigen::Vector3d::UnitZ())),
                      Eigen::Vector3d(0.2, -0.1, 0)};
  for (const int i : {5, 0, 2, 7}) Add(i, turned, 40, turned, 30);
  const std::vector<RigMotion> found = Found();
  ASSERT_FALSE(found.empty());
  EXPECT_TRUE(found[0].clear);
  EXPECT_LT(found[0].rig_from_template.rotation.angularDistance(turned.rotation), 1e-4);
  EXPECT_EQ(found[0].rig_view, (std::vector<int>{5, 0, 2, 7}));
}

TEST_F(RigMotions, ThatItStayedIsTriedTooWhereAnotherHalfHasMoreMatches) {
  const Rigid3 tilted = Tilted(35);
  Add(5, tilted, 90, Rigid3(), 4);
  Add(0, tilted, 60, Rigid3(), 8);
  Add(2, tilted, 5, Rigid3(), 16);
  Add(7, tilted, 3, Rigid3(), 18);
  const std::vector<RigMotion> found = Found();
  ASSERT_GE(found.size(), 2u);
  EXPECT_NEAR(Degrees(found[0]), 35, 1);
  EXPECT_FALSE(found[0].clear) << "only half of the photographs agree";
  EXPECT_EQ(Degrees(found[1]), 0);
  EXPECT_EQ(found[1].agreeing, 2);
  EXPECT_EQ(found[1].rig_view, (std::vector<int>{-1, -1, 2, 7}));
}

TEST_F(RigMotions, ThatItStayedIsTriedTooWhereItIsLikeliestButNotClear) {
  Add(5, Rigid3(), 40, Rigid3(), 30);
  Add(0, Rigid3(), 35, Rigid3(), 30);
  for (const int i : {2, 7, 3}) Add(i, Rigid3(), 3, Rigid3(), 2);
  const std::vector<RigMotion> found = Found();
  ASSERT_GE(found.size(), 2u);
  EXPECT_LT(Degrees(found[0]), 0.01);
  EXPECT_FALSE(found[0].clear) << "two photographs of five agree";
  EXPECT_EQ(Degrees(found[1]), 0);
  EXPECT_EQ(found[1].rig_view, (std::vector<int>{5, 0, -1, -1, -1}));
}

TEST_F(RigMotions, OnePhotographWithManyMatchesDoesNotOutvoteTheOthers) {
  const Rigid3 turned{Eigen::Quaterniond(Eigen::AngleAxisd(0.6, Eigen::Vector3d::UnitZ())),
                      Eigen::Vector3d(0.2, -0.1, 0)};
  const Rigid3 tilted = Compose(turned, Tilted(35));
  Add(5, tilted, 120, turned, 2);
  for (const int i : {0, 2, 7}) Add(i, tilted, 3, turned, 16);
  const std::vector<RigMotion> found = Found();
  const bool tried = std::any_of(found.begin(), found.end(), [&](const RigMotion& motion) {
    return motion.agreeing == 3 &&
           motion.rig_from_template.rotation.angularDistance(turned.rotation) < 1e-3;
  });
  EXPECT_TRUE(tried);
}

TEST_F(RigMotions, WithoutACameraThereIsNone) {
  Add(5, Rigid3(), 40, Rigid3(), 30);
  cameras_[0].found = false;
  EXPECT_TRUE(Found().empty());
}

}  // namespace keypose::fit::rig_motions_test
