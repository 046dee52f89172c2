#include "fit/limbs/limb_search.h"

#include <gtest/gtest.h>

#include "core/numbers/parallel.h"
#include "core/numbers/rotations.h"
#include "core/pictures/render.h"
#include "fit/limbs/limbs.h"
#include "fit/limbs/testing/bottle.h"

namespace keypose::fit::limb_search_test {

/// The hand turned about its arm and bent at the wrist.
PointsX3 WithTurnedHand(const Mesh& mesh) {
  const Eigen::Vector3d wrist(0, 0, kWrist), turn(0.35, 0.1, 0.9);
  PointsX3 moved = mesh.points;
  for (int v = 0; v < mesh.vertex_count(); ++v) {
    const Eigen::Vector3d x = mesh.points.row(v).transpose();
    const Eigen::Matrix3d r = ExpOf(Smooth(kWrist - 0.25, kWrist + 0.25, x.z()) * turn);
    moved.row(v) = (r * (x - wrist) + wrist).transpose();
  }
  return moved;
}

std::vector<SmallPicture> PicturesOf(Mesh mesh, const PointsX3& points) {
  constexpr int kSide = 400;
  mesh.points = points;
  const RayScene scene(mesh.points, mesh.faces);
  std::vector<SmallPicture> pictures;
  for (const double azimuth : {0, 80, 170, 260}) {
    const View view = FitView(mesh.points, azimuth, 20, kSide, kSide);
    Image8 mask(kSide, kSide, 1);
    const Raster raster = Rasterize(mesh, scene, view);
    for (std::size_t i = 0; i < mask.data.size(); ++i)
      mask.data[i] = raster.face.data[i] >= 0 ? 255 : 0;
    const PreparedView prepared = PrepareView(view, 0, Render(mesh, scene, view), mask, 1, 2);
    pictures.push_back(MakeSmallPicture(prepared, prepared.camera_from_world, 45));
  }
  return pictures;
}

TEST(TurnLimbs, AHandThatTurnedAboutItsArmIsFound) {
  const Mesh mesh = MakeBottle();
  const Limb arm = ArmOf(mesh);
  const PointsX3 truth = WithTurnedHand(mesh);
  const std::vector<SmallPicture> pictures = PicturesOf(mesh, truth);
  const Eigen::MatrixX3f colors = mesh.colors.cast<float>();
  SetThreadCount(1);
  const TurnedLimbs one = TurnLimbs(mesh.points, mesh.faces, colors, pictures, mesh.points);
  SetThreadCount(3);
  const TurnedLimbs three = TurnLimbs(mesh.points, mesh.faces, colors, pictures, mesh.points);
  SetThreadCount(0);
  EXPECT_EQ(one.points, three.points);
  EXPECT_EQ(one.count, 1);
  EXPECT_LT(MeanError(one.points, truth, arm.vertices),
            0.5 * MeanError(mesh.points, truth, arm.vertices));
  for (int v = 0; v < mesh.vertex_count(); ++v) {
    if (one.turned[v]) continue;
    EXPECT_EQ(one.points.row(v), mesh.points.row(v));
  }
}

TEST(TurnLimbs, StopsWhenAsked) {
  class Cancelling final : public Progress {
    void Update(double, std::string_view) override {}
    bool cancelled() const override { return true; }
  } cancelling;
  const Mesh mesh = MakeBottle();
  EXPECT_THROW(
      TurnLimbs(mesh.points, mesh.faces, mesh.colors.cast<float>(), {}, mesh.points, &cancelling),
      Cancelled);
}

TEST(TurnLimbs, OneThatIsRightStays) {
  const Mesh mesh = MakeBottle();
  const PointsX3 truth = WithTurnedHand(mesh);
  const TurnedLimbs found =
      TurnLimbs(mesh.points, mesh.faces, mesh.colors.cast<float>(), PicturesOf(mesh, truth), truth);
  EXPECT_EQ(found.count, 0);
  EXPECT_EQ(found.points, truth);
}

}  // namespace keypose::fit::limb_search_test
