// A photograph without a camera finds it among those of a rig, or by picks.
#include "fit/cameras/late_cameras.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/render.h"
#include "core/testing_shapes.h"

namespace keypose::fit {
namespace {

constexpr int kSide = 420;

/// A lump without symmetry, with its own texture coordinates by longitude and latitude.
Mesh Lump() {
  Mesh mesh = MakeIcosphere(4);
  for (Eigen::Index v = 0; v < mesh.points.rows(); ++v) {
    const Eigen::Vector3d p = mesh.points.row(v);
    const double bump = std::exp(-4 * (p - Eigen::Vector3d(0.8, 0.5, 0.3)).squaredNorm());
    mesh.points.row(v) =
        (1 + 0.6 * bump) * p.transpose().array() * Eigen::Array3d(1, 0.7, 1.2).transpose();
  }
  const Mesh ball = MakeIcosphere(4);
  mesh.uvs.resize(3 * mesh.face_count(), 2);
  mesh.uv_faces.resize(mesh.face_count(), 3);
  for (int f = 0; f < mesh.face_count(); ++f) {
    const double first =
        std::atan2(ball.points(ball.faces(f, 0), 1), ball.points(ball.faces(f, 0), 0));
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d p = ball.points.row(ball.faces(f, k));
      double turn = std::atan2(p.y(), p.x());
      turn -= 2 * M_PI * std::round((turn - first) / (2 * M_PI));  // no face spans the seam
      mesh.uvs.row(3 * f + k) << std::clamp((turn + M_PI) / (2 * M_PI), 0.0, 1.0),
          std::asin(std::clamp(p.z(), -1.0, 1.0)) / M_PI + 0.5;
      mesh.uv_faces(f, k) = 3 * f + k;
    }
  }
  return mesh;
}

/// Spots of many sizes.
Image8 Spots() {
  Image8 texture(1024, 512, 3);
  for (std::uint8_t& value : texture.data) value = 128;
  std::mt19937 random(4);
  for (int i = 0; i < 3000; ++i) {
    const int cx = random() % 1024, cy = random() % 512, r = 2 + random() % 9;
    const auto shade = static_cast<std::uint8_t>(random() % 256);
    for (int y = std::max(0, cy - r); y < std::min(512, cy + r); ++y)
      for (int x = std::max(0, cx - r); x < std::min(1024, cx + r); ++x)
        if ((x - cx) * (x - cx) + (y - cy) * (y - cy) < r * r)
          for (int c = 0; c < 3; ++c) texture.at(x, y)[c] = shade;
  }
  return texture;
}

class LateCameras : public testing::Test {
 protected:
  LateCameras() : mesh_(Lump()), texture_(Spots()) {
    for (int i = 0; i < 8; ++i) rig_.push_back(FitView(mesh_.points, 45 * i, 20, kSide, kSide));
  }
  /// A photograph from the rig's camera, with what it shows as mask.
  PreparedView Photograph(int i) const {
    RenderOptions options;
    options.texture = &texture_;
    options.shading = 0;
    const RayScene scene(mesh_.points, mesh_.faces);
    const Image8 cutout = RenderCutout(mesh_, scene, rig_[i], options);
    Image8 mask(kSide, kSide, 1);
    for (int y = 0; y < kSide; ++y)
      for (int x = 0; x < kSide; ++x) *mask.at(x, y) = cutout.at(x, y)[3] > 127 ? 255 : 0;
    return PrepareView(rig_[i], 0, Render(mesh_, scene, rig_[i], options), mask, 1, 3);
  }

  Mesh mesh_;
  Image8 texture_;
  std::vector<View> rig_;
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

TEST_F(LateCameras, WithoutARigAndWithoutFeaturesNothingIsFound) {
  std::vector<FoundCamera> cameras(1);
  EXPECT_EQ(FindLateCameras(mesh_, texture_, {Photograph(0)}, {}, cameras), 0);
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

FoundCamera WithInliers(int inliers) {
  FoundCamera camera;
  camera.found = true;
  camera.inliers = inliers;
  camera.matches.resize(100);
  return camera;
}

TEST(KeepSureCameras, LeavesOutWhatFewMatchesAgreeWith) {
  std::vector<FoundCamera> cameras = {WithInliers(50), WithInliers(20), WithInliers(37),
                                      WithInliers(69)};
  EXPECT_TRUE(KeepSureCameras(cameras));
  EXPECT_TRUE(cameras[0].found && cameras[2].found && cameras[3].found);
  EXPECT_FALSE(cameras[1].found);
  EXPECT_FALSE(KeepSureCameras(cameras)) << "nothing is left to leave out";
}

TEST(KeepSureCameras, LeavesAllWhereTooFewAreSure) {
  std::vector<FoundCamera> cameras = {WithInliers(50), WithInliers(20), WithInliers(14),
                                      WithInliers(69)};
  EXPECT_FALSE(KeepSureCameras(cameras));
  for (const FoundCamera& camera : cameras) EXPECT_TRUE(camera.found);
}

}  // namespace
}  // namespace keypose::fit
