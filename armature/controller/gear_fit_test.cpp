#include "armature/controller/gear_fit.h"

#include <gtest/gtest.h>

#include "core/values/errors.h"

namespace keypose::armature::gear_fit_test {

TEST(FitGear, FindsRatioAndOffsetAndWhatIsLeft) {
  std::vector<KnownAngle> known;
  for (const double value : {0.0, 0.5, 1.0, -1.5}) known.push_back({value, 1.004 * value + 0.01});
  const GearFit fit = FitGear(known);
  EXPECT_NEAR(fit.gear, 1.004, 1e-12);
  EXPECT_NEAR(fit.offset, 0.01, 1e-12);
  EXPECT_LT(fit.residual, 1e-12);
  known[0].read += 0.001;
  EXPECT_GT(FitGear(known).residual, 2e-4);
}

TEST(FitGear, OneAngleOrAWrongScaleIsAFault) {
  EXPECT_THROW(FitGear({{0, 0}}), InputError);
  EXPECT_THROW(FitGear({{0.3, 0}, {0.3, 0.1}}), InputError);
  EXPECT_THROW(FitGear({{0, 0}, {1, -1}}), InputError);
  EXPECT_THROW(FitGear({{0, 0}, {1, 25}}), InputError);
}

}  // namespace keypose::armature::gear_fit_test
