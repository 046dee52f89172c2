// A bottle with an arm and a hand, whose hand is turned: limbs, their joints, and the search.
#include "fit/limbs/limbs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/numbers/parallel.h"
#include "core/numbers/rotations.h"
#include "core/pictures/render.h"
#include "core/surfaces/shapes.h"
#include "core/values/size_of.h"
#include "fit/limbs/limb_chain.h"
#include "fit/limbs/limb_search.h"

namespace keypose::fit::limbs_test {

constexpr double kNeck = 1.3, kWrist = 2.2, kTop = 3;

double Smooth(double from, double to, double at) {
  const double t = std::clamp((at - from) / (to - from), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

/// Along z: a body of radius 1.8 up to the neck, an arm of radius 0.2, a flat hand with a thumb.
Mesh MakeBottle() {
  Mesh mesh = MakeCylinder(1, kTop, 20, 44);
  mesh.colors.resize(mesh.vertex_count(), 3);
  for (int v = 0; v < mesh.vertex_count(); ++v) {
    const double x = mesh.points(v, 0), y = mesh.points(v, 1), z = mesh.points(v, 2);
    const double closed = std::sqrt(std::max(0.0, std::min({1.0, z / 0.3, (kTop - z) / 0.25})));
    const double arm = Smooth(kNeck - 0.2, kNeck, z), hand = Smooth(kWrist, kWrist + 0.2, z);
    const double radius = closed * ((1 - arm) * 1.8 + arm * 0.2);
    const double thumb = x > 0 ? 0.3 * std::exp(-std::pow((z - 2.55) / 0.12, 2)) * x : 0;
    mesh.points(v, 0) = radius * x * (1 + 0.8 * hand) + closed * hand * thumb;
    mesh.points(v, 1) = radius * y * (1 - 0.3 * hand);
    if (hand > 0.5)
      mesh.colors.row(v) << 230, 190, y > 0 ? 60 : 150;
    else
      mesh.colors.row(v) << 110, 80, z > kNeck ? 170 : 90;
  }
  return mesh;
}

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

/// The limb that holds the bottle's top.
Limb ArmOf(const Mesh& mesh) {
  for (Limb& limb : FindLimbs(mesh.points, mesh.faces))
    for (const int v : limb.vertices)
      if (mesh.points(v, 2) > kTop - 0.05) return std::move(limb);
  ADD_FAILURE() << "no limb at the top";
  return {};
}

double MeanError(const PointsX3& a, const PointsX3& b, const std::vector<int>& vertices) {
  double sum = 0;
  for (const int v : vertices) sum += (a.row(v) - b.row(v)).norm();
  return sum / SizeOf(vertices);
}

TEST(FindLimbs, AnArmEndsWhereTheBodyBegins) {
  const Mesh mesh = MakeBottle();
  const Limb arm = ArmOf(mesh);
  double lowest = kTop;
  for (const int v : arm.vertices) lowest = std::min(lowest, mesh.points(v, 2));
  EXPECT_GT(lowest, kNeck - 0.25);
  EXPECT_LT(lowest, kNeck + 0.4);
  EXPECT_TRUE(std::is_sorted(arm.vertices.begin(), arm.vertices.end()));
  int missing = 0;
  for (int v = 0; v < mesh.vertex_count(); ++v)
    missing += mesh.points(v, 2) > kNeck + 0.5 &&
               !std::binary_search(arm.vertices.begin(), arm.vertices.end(), v);
  EXPECT_EQ(missing, 0);
  EXPECT_DOUBLE_EQ(arm.along.minCoeff(), 0);
  EXPECT_DOUBLE_EQ(arm.along.maxCoeff(), arm.length);
}

TEST(FindLimbs, ABallHasNone) {
  const Mesh ball = MakeIcosphere(4);
  EXPECT_TRUE(FindLimbs(ball.points, ball.faces).empty());
}

TEST(LimbChain, WithoutTurnsALimbThatMovedRigidlyStays) {
  const Mesh mesh = MakeBottle();
  const Limb arm = ArmOf(mesh);
  const Eigen::Matrix3d turn = ExpOf({0.4, -0.3, 1.1});
  const PointsX3 now = (mesh.points * turn.transpose()).rowwise() + Eigen::RowVector3d(1, 2, 3);
  const LimbChain chain(arm, mesh.points, now);
  const PointsX3 stayed = chain.Turned(LimbChain::Turns::Zero());
  EXPECT_LT((stayed - now(arm.vertices, Eigen::all)).norm(), 1e-9);
  const std::vector<int> some{0, 3, 7};
  EXPECT_EQ(chain.Turned(LimbChain::Turns::Zero(), some), stayed(some, Eigen::all));
}

TEST(LimbChain, TheTipTurnsRigidlyAndTheBaseStays) {
  const Mesh mesh = MakeBottle();
  const Limb arm = ArmOf(mesh);
  const LimbChain chain(arm, mesh.points, mesh.points);
  LimbChain::Turns turns = LimbChain::Turns::Zero();
  turns.tail<3>() << 0.2, -0.5, 1;
  const PointsX3 moved = chain.Turned(turns);
  std::vector<int> tip;
  for (int i = 0; i < SizeOf(arm.vertices); ++i) {
    if (arm.along[i] < 0.1) tip.push_back(i);
    if (arm.along[i] > 0.95 * arm.length) {
      EXPECT_LT((moved.row(i) - mesh.points.row(arm.vertices[i])).norm(), 1e-9);
    }
  }
  ASSERT_GT(SizeOf(tip), 10);
  const PointsX3 before = mesh.points(arm.vertices, Eigen::all)(tip, Eigen::all),
                 after = moved(tip, Eigen::all);
  const Similarity3 fitted = FitSimilarity(before, after, {}, false);
  EXPECT_LT((Transformed(fitted, before) - after).norm(), 1e-9);
  EXPECT_LT((fitted.rotation - ExpOf(turns.tail<3>())).norm(), 1e-9);
}

TEST(LimbChain, ASqueezedTipIsWholeAgain) {
  const Mesh mesh = MakeBottle();
  const Limb arm = ArmOf(mesh);
  PointsX3 squeezed = mesh.points;
  for (int v = 0; v < mesh.vertex_count(); ++v)
    if (mesh.points(v, 2) > kWrist + 0.2) squeezed(v, 0) *= 0.6;
  const LimbChain chain(arm, mesh.points, squeezed);
  PointsX3 whole = squeezed;
  whole(arm.vertices, Eigen::all) = chain.Turned(LimbChain::Turns::Zero());
  EXPECT_LT(MeanError(whole, mesh.points, arm.vertices),
            0.5 * MeanError(squeezed, mesh.points, arm.vertices));
}

TEST(LimbChain, AThinLimbOfLongFacesTurnsToo) {
  const Mesh thin = MakeCylinder(0.01, 2, 6, 2);
  Limb limb;
  for (int v = 0; v < thin.vertex_count(); ++v) limb.vertices.push_back(v);
  limb.along = 2 - thin.points.col(2).array();
  limb.length = 2;
  const LimbChain chain(limb, thin.points, thin.points);
  EXPECT_LT((chain.Turned(LimbChain::Turns::Zero()) - thin.points).norm(), 1e-9);
  EXPECT_TRUE(chain.Turned(LimbChain::Turns::Constant(0.5)).allFinite());
}

TEST(MakeSmallPicture, ShowsAPointAtTheSamePlace) {
  const Mesh mesh = MakeBottle();
  const View view = FitView(mesh.points, 30, 20, 400, 300);
  const PreparedView prepared =
      PrepareView(view, 0, Image8(400, 300, 3, 90), Image8(400, 300, 1, 255), 1, 2);
  const double size = view.camera.fx / view.camera_from_world.translation.norm();
  const SmallPicture small = MakeSmallPicture(prepared, view.camera_from_world, size / 2);
  EXPECT_EQ(small.mask.width, 200);
  EXPECT_EQ(small.mask.data[5000], 1);
  EXPECT_FLOAT_EQ(small.colors.data[5000], 90);
  const Eigen::Vector3d x(0.3, -0.2, 1.9);
  EXPECT_LT((2 * small.view.Project(x) - view.Project(x)).norm(), 1e-9);
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

}  // namespace keypose::fit::limbs_test
