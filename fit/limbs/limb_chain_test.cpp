#include "fit/limbs/limb_chain.h"

#include <gtest/gtest.h>

#include "core/numbers/rotations.h"
#include "core/surfaces/shapes.h"
#include "core/values/size_of.h"
#include "fit/limbs/limbs.h"
#include "fit/limbs/testing/bottle.h"

namespace keypose::fit::limb_chain_test {

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

}  // namespace keypose::fit::limb_chain_test
