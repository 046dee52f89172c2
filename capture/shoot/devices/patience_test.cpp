#include "capture/shoot/devices/patience.h"

#include <gtest/gtest.h>

namespace keypose::capture::shoot::patience_test {

TEST(PlainPatience, WaitsAtLeastSoLongAndNotAtAllForZero) {
  PlainPatience patience;
  const double begin = patience.Now();
  patience.Wait(0);
  patience.Wait(0.02);
  EXPECT_GE(patience.Now() - begin, 0.02);
}

}  // namespace keypose::capture::shoot::patience_test
