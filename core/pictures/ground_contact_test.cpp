#include "core/pictures/ground_contact.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/pictures/render.h"
#include "core/surfaces/ray_scene.h"
#include "core/surfaces/shapes.h"
#include "core/testing/shots.h"
#include "core/values/size_of.h"

namespace keypose::ground_contact_test {

using Eigen::Vector3d;

/// Rings of 12 cameras; a pixel is 0.005 units.
MaskShot Photograph(const Mesh& mesh, const std::vector<double>& elevations_deg) {
  const Vector3d middle =
      (mesh.points.colwise().minCoeff() + mesh.points.colwise().maxCoeff()).transpose() / 2;
  return MasksFromRings(mesh, middle, elevations_deg, 12, 400);
}

/// A cylinder of radius 0.4 and height 1.2 that stands at 0.3. The visual hull of views at 12
/// degrees continues below it for 0.085.
Mesh Drum() {
  Mesh drum = MakeCylinder(0.4, 1.2, 48, 8);
  drum.points.col(2).array() += 0.3 - drum.points.col(2).minCoeff();
  return drum;
}

const Vector3d kLow(-0.4, -0.4, 0.36),
    kHigh(0.4, 0.4, 1.5);  // approximate: the low side has an error of 0.06

TEST(FindGroundContact, OutlinesTellWhereADrumStandsToAHundredthOfItsHeight) {
  for (const std::vector<double>& rings : {std::vector<double>{25}, {12, 40}}) {
    const MaskShot shot = Photograph(Drum(), rings);
    const auto contact = FindGroundContact(shot.views, shot.masks, kLow, kHigh);
    ASSERT_TRUE(contact);
    EXPECT_NEAR(contact->height, 0.3, 0.012) << rings.size() << " rings";
    EXPECT_LT(contact->spread, 0.005);
    EXPECT_EQ(contact->views, SizeOf(shot.views));
  }
}

TEST(FindGroundContact, ARoundSoleIsFoundBelowWhatAnyCameraSees) {
  // The lower edge of the cylinder gets a chamfer of 45 degrees and 0.04. The upper ring sees its
  // outer end, at 0.34.
  Mesh drum = Drum();
  for (Eigen::Index v = 0; v < drum.points.rows(); ++v)
    if (drum.points(v, 2) < 0.301 && drum.points.row(v).head<2>().norm() > 0.01)
      drum.points.row(v).head<2>() *= 0.9;
  for (Eigen::Index v = 0; v < drum.points.rows(); ++v)
    if (std::abs(drum.points(v, 2) - 0.45) < 0.01) drum.points(v, 2) = 0.34;
  const MaskShot shot = Photograph(drum, {12, 50});
  const auto contact = FindGroundContact(shot.views, shot.masks, kLow, kHigh);
  ASSERT_TRUE(contact);
  EXPECT_NEAR(contact->height, 0.3, 0.02);  // half of the chamfer: the unseen part is extrapolated
}

TEST(FindGroundContact, TwoMasksWithoutAFootAndAnEmptyOneDoNotMoveIt) {
  MaskShot shot = Photograph(Drum(), {12, 40});
  for (const int v : {3, 17})
    for (int y = 240; y < 400; ++y)
      for (int x = 0; x < 400; ++x) *shot.masks[v].at(x, y) = 0;
  shot.masks[8] = Image8();
  const auto contact = FindGroundContact(shot.views, shot.masks, kLow, kHigh);
  ASSERT_TRUE(contact);
  EXPECT_NEAR(contact->height, 0.3, 0.01);
}

TEST(FindGroundContact, ViewsFromBelowAndTooFewOfThemTellNothing) {
  const MaskShot below = Photograph(Drum(), {-30});
  EXPECT_FALSE(FindGroundContact(below.views, below.masks, kLow, kHigh));
  MaskShot few = Photograph(Drum(), {25});
  few.views.resize(2), few.masks.resize(2);
  EXPECT_FALSE(FindGroundContact(few.views, few.masks, kLow, kHigh));
}

}  // namespace keypose::ground_contact_test
