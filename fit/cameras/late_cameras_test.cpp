// A photograph without a camera finds it among those of a rig, or by picks.
#include "fit/cameras/late_cameras.h"

#include <gtest/gtest.h>

#include "core/surfaces/ray_scene.h"
#include "fit/testing/spotted_lump.h"

namespace keypose::fit::late_cameras_test {

class LateCameras : public ::testing::Test {
 protected:
  PreparedView Photograph(int i) const { return PhotographOf(mesh_, texture_, rig_[i]); }

  Mesh mesh_ = SpottedLump();
  Image8 texture_ = Spots();
  std::vector<View> rig_ = RingAround(mesh_, {0, 45, 90, 135, 180, 225, 270, 315});
};

TEST_F(LateCameras, TheRigsCameraWhoseRenderAgreesIsTaken) {
  std::vector<FoundCamera> cameras(1);
  ASSERT_EQ(FindLateCameras(mesh_, texture_, {Photograph(3)}, rig_, cameras), 1);
  EXPECT_TRUE(cameras[0].found);
  EXPECT_EQ(cameras[0].camera_from_world.translation, rig_[3].camera_from_world.translation);
  EXPECT_GE(cameras[0].matches.size(), 15u);
}

TEST_F(LateCameras, NoneIsTakenWhereTheRigHasNoSuchCamera) {
  const PreparedView view = Photograph(3);
  rig_.erase(rig_.begin() + 2, rig_.begin() + 5);
  std::vector<FoundCamera> cameras(1);
  EXPECT_EQ(FindLateCameras(mesh_, texture_, {view}, rig_, cameras), 0);
  EXPECT_FALSE(cameras[0].found);
}

TEST_F(LateCameras, WithoutARigItIsFoundFromAllSides) {
  std::vector<FoundCamera> cameras(1);
  const PreparedView view = Photograph(3);
  ASSERT_EQ(FindLateCameras(mesh_, texture_, {view}, {}, cameras), 1);
  EXPECT_LT((cameras[0].camera_from_world.Inverse().translation - view.Center()).norm(),
            0.01 * view.Center().norm());
}

TEST_F(LateCameras, WithoutARigAndWithoutFeaturesNothingIsFound) {
  const PreparedView view = Photograph(0);
  for (std::uint8_t& value : texture_.data) value = 128;
  std::vector<FoundCamera> cameras(1);
  EXPECT_EQ(FindLateCameras(mesh_, texture_, {view}, {}, cameras), 0);
}

/// Picks of vertices that the view shows, without an error.
std::vector<FeatureMatch> PicksIn(const Mesh& mesh, const PreparedView& view, int count) {
  const RayScene scene(mesh.points, mesh.faces);
  std::vector<FeatureMatch> picks;
  for (int v = 0; v < mesh.vertex_count() && static_cast<int>(picks.size()) < count; v += 97) {
    const Eigen::Vector3d x = mesh.points.row(v);
    constexpr double kBefore = 0.99;
    if (scene.Occluded(view.Center(), x - view.Center(), 0, kBefore)) continue;
    FeatureMatch pick;
    pick.point.vertices.setConstant(v);
    pick.pixel = view.camera().Project(view.camera_from_world * x);
    picks.push_back(pick);
  }
  return picks;
}

TEST_F(LateCameras, SixPicksFindTheCameraOfAFigureWithoutTexture) {
  for (std::uint8_t& value : texture_.data) value = 128;
  const SurfaceFeatures features(mesh_, texture_);
  const PreparedView view = Photograph(3);
  const std::vector<FeatureMatch> picks = PicksIn(mesh_, view, 6);
  ASSERT_EQ(picks.size(), 6u);
  EXPECT_FALSE(FindCameras(mesh_, &features, {view}, {{}})[0].found);
  const FoundCamera camera = FindCameras(mesh_, &features, {view}, {picks})[0];
  ASSERT_TRUE(camera.found);
  EXPECT_LT((camera.camera_from_world.translation - view.camera_from_world.translation).norm(),
            1e-3 * view.camera_from_world.translation.norm());
}

TEST_F(LateCameras, WithoutATextureOutlinesTellTheCamerasOfARigApart) {
  std::vector<FoundCamera> cameras(3);
  const std::vector<PreparedView> views = {Photograph(5), Photograph(0), Photograph(3)};
  ASSERT_EQ(PlaceByOutlines(mesh_, views, rig_, cameras), 3);
  for (const auto& [i, of] : {std::pair{0, 5}, {1, 0}, {2, 3}})
    EXPECT_EQ(cameras[i].camera_from_world.translation, rig_[of].camera_from_world.translation);
}

TEST_F(LateCameras, ByOutlinesNoCameraIsTakenTwiceAndNoneThatDoesNotOverlap) {
  std::vector<FoundCamera> cameras(2);
  EXPECT_EQ(PlaceByOutlines(mesh_, {Photograph(2), Photograph(2)}, {rig_[2]}, cameras), 1);
  Mesh away = mesh_;
  away.points.col(2).array() += 5;
  cameras.assign(2, {});
  EXPECT_EQ(PlaceByOutlines(away, {Photograph(2), Photograph(3)}, rig_, cameras), 0);
}

}  // namespace keypose::fit::late_cameras_test
