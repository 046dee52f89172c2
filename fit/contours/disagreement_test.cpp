#include "fit/contours/disagreement.h"

#include <gtest/gtest.h>

#include <cmath>

#include "fit/contours/outline.h"
#include "fit/contours/testing/disc_view.h"

namespace keypose::fit::disagreement_test {

TEST(WorstDisagreement, IsWhereTheOneIsBeyondTheOther) {
  const double radius = SphereRadius();
  for (const double mask : {60.0, 40.0}) {
    PreparedView view = DiscView(mask);
    const Disagreement found = WorstDisagreement(SphereSilhouette(view), MakeOutline(view, 0));
    EXPECT_NEAR(found.distance_px, std::abs(mask - radius), 1);
    EXPECT_EQ(found.mask_beyond, mask > radius);
    const double from_middle = (found.pixel - Eigen::Vector2d::Constant(kMiddle)).norm();
    EXPECT_NEAR(from_middle, std::max(mask, radius), 1);
  }
}

TEST(WorstDisagreement, ASpurOfTheMaskIsFound) {
  PreparedView view = DiscView(SphereRadius());
  for (int x = 100; x < 190; ++x)
    for (int y = 96; y < 104; ++y) *view.levels[0].grey.at(x, y) = 1;
  const Disagreement found = WorstDisagreement(SphereSilhouette(view), MakeOutline(view, 0));
  EXPECT_TRUE(found.mask_beyond);
  EXPECT_NEAR(found.pixel.x(), 189, 2);
  EXPECT_NEAR(found.distance_px, 189 - kMiddle - SphereRadius(), 2);
  EXPECT_EQ(WorstDisagreement({}, MakeOutline(view, 0)).distance_px, 0);
}

}  // namespace keypose::fit::disagreement_test
