#include "reconstruct/sfm/measurements.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "reconstruct/testing/reported_stage.h"

namespace keypose::reconstruct::measurements_test {

using ::testing::ElementsAre;
using ::testing::Pair;

TEST(Measurements, KeepTheirOrderAndTheLastValueOfAName) {
  Measurements measurements;
  measurements.Add("second_try", false);
  measurements.Add("error_px", 0.5);
  measurements.Add("second_try", true);
  ASSERT_EQ(measurements.values().size(), 2U);
  EXPECT_EQ(measurements.values()[0].first, "second_try");
  EXPECT_EQ(std::get<bool>(measurements.values()[0].second), true);
  EXPECT_EQ(std::get<double>(*measurements.Find("error_px")), 0.5);
  EXPECT_EQ(measurements.Find("error"), nullptr);
}

TEST(Measurements, ReachTheReportWithTheirKinds) {
  Measurements measurements;
  measurements.Add("is_ring", true);
  measurements.Add("points", 7);
  measurements.Add("error_px", 0.5);
  measurements.Add("layout", "18+18");
  measurements.AddJson("sizes", "[3,4]");
  measurements.Warn("look");
  ReportedStage stage;
  measurements.Report(stage);
  EXPECT_THAT(stage.values,
              ElementsAre(Pair("error_px", "0.500000"), Pair("is_ring", "true"),
                          Pair("layout", "18+18"), Pair("points", "7"), Pair("sizes", "[3,4]")));
  EXPECT_THAT(stage.warnings, ElementsAre("look"));
}

}  // namespace keypose::reconstruct::measurements_test
