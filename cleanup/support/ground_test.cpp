// Soles that no photograph shows are cut flat if the figure stands on the ground, and stay
// unchanged if not.
#include "cleanup/support/ground.h"

#include <gtest/gtest.h>

#include "cleanup/testing/pawn.h"
#include "core/testing/shots.h"

namespace keypose::cleanup::ground_test {


/// The pawn with a thin rod below. The lower photographs show a third of the rod.
Mesh WithRod() { return Pawn({{0.2, 0}, {0.06, 0}, {0.05, -0.1}, {0.05, -0.24}}); }

TEST(StandsOnGround, FigureOnItsFeetDoesAndWhatIsSeenBelowOrFarAwayDoesNot) {
  const MaskShot shot = Photograph(TruePawn(), {12, 40});
  EXPECT_TRUE(StandsOnGround(WithCap(), shot.views, shot.masks).stands);
  EXPECT_TRUE(StandsOnGround(TruePawn(), shot.views, shot.masks).stands);

  // The figure is held by a rig: the outlines end above z = 0.
  Mesh up = WithCap(), up_truth = TruePawn();
  up.points.col(2).array() += 0.08, up_truth.points.col(2).array() += 0.08;
  const MaskShot rig = Photograph(up_truth, {12, 40});
  EXPECT_FALSE(StandsOnGround(up, rig.views, rig.masks).stands);

  // Photographs show a rod below the ground, which is too thin to affect the ground's estimated
  // height.
  const MaskShot rod = Photograph(WithRod(), {12, 40});
  EXPECT_FALSE(StandsOnGround(WithRod(), rod.views, rod.masks).stands);

  // Also photographed from below, as when it lies on its back.
  const MaskShot lying = Photograph(TruePawn(), {12, 40, -30});
  EXPECT_FALSE(StandsOnGround(WithCap(), lying.views, lying.masks).stands);

  EXPECT_FALSE(StandsOnGround(WithCap(), {}, {}).stands);
}

TEST(StandsOnGround, NothingIsBelowABoard) {
  // Masks that are too large at the soles: the outlines end below z = 0 by 2 % of the height.
  Mesh mesh = WithCap(), seen = TruePawn();
  const double tall = seen.points.col(2).maxCoeff();
  mesh.points.col(2).array() -= 0.02 * tall, seen.points.col(2).array() -= 0.02 * tall;
  const MaskShot low = Photograph(seen, {12, 40});
  EXPECT_FALSE(StandsOnGround(mesh, low.views, low.masks).stands);
  EXPECT_TRUE(StandsOnGround(mesh, low.views, low.masks, GroundKind::kBoard).stands);
  // A board does not make it stand that is held above it.
  mesh.points.col(2).array() += 0.04 * tall, seen.points.col(2).array() += 0.04 * tall;
  const MaskShot high = Photograph(seen, {12, 40});
  EXPECT_FALSE(StandsOnGround(mesh, high.views, high.masks, GroundKind::kBoard).stands);
}

// The plane is known: outlines need not end there. A camera that looks up from below shows soles.
TEST(StandsOnGround, OnAKnownFloorUnlessCamerasLookUp) {
  Mesh mesh = WithCap(), seen = TruePawn();
  const double tall = seen.points.col(2).maxCoeff();
  mesh.points.col(2).array() -= 0.07 * tall, seen.points.col(2).array() -= 0.07 * tall;
  const MaskShot low = Photograph(seen, {12, 40});
  EXPECT_FALSE(StandsOnGround(mesh, low.views, low.masks, GroundKind::kBoard).stands);
  EXPECT_TRUE(StandsOnGround(mesh, low.views, low.masks, GroundKind::kFloor).stands);
  const MaskShot lying = Photograph(seen, {12, 40, -30});
  EXPECT_FALSE(StandsOnGround(mesh, lying.views, lying.masks, GroundKind::kFloor).stands);
}

}  // namespace keypose::cleanup::ground_test
