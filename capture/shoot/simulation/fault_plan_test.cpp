#include "capture/shoot/simulation/fault_plan.h"

#include <gtest/gtest.h>

#include "core/values/errors.h"

namespace keypose::capture::shoot::fault_plan_test {

TEST(ParseFaults, ReadsKindsAndMoments) {
  const std::vector<PlannedFault> faults = ParseFaults("lost-reply@5,stall@9");
  ASSERT_EQ(faults.size(), 2u);
  EXPECT_EQ(faults[0].kind, "lost-reply");
  EXPECT_EQ(faults[0].at, 5);
  EXPECT_EQ(faults[1].kind, "stall");
  EXPECT_EQ(faults[1].at, 9);
  EXPECT_TRUE(ParseFaults("").empty());
}

TEST(ParseFaults, NamesWhatItDoesNotKnow) {
  try {
    ParseFaults("stal@2");
    FAIL();
  } catch (const UsageError& error) {
    EXPECT_NE(std::string(error.what()).find("did you mean 'stall'"), std::string::npos);
  }
  for (const char* text : {"stall", "stall@", "stall@0", "stall@2x", "stall@-1"})
    EXPECT_THROW(ParseFaults(text), UsageError) << text;
}

TEST(FaultPlan, EachFaultIsDueOnce) {
  FaultPlan plan(ParseFaults("stall@2,stall@2,unplug@1"));
  EXPECT_FALSE(plan.Due("stall", 1));
  EXPECT_TRUE(plan.Due("unplug", 1));
  EXPECT_FALSE(plan.Due("unplug", 1));
  EXPECT_TRUE(plan.Due("stall", 2));
  EXPECT_TRUE(plan.Due("stall", 2));
  EXPECT_FALSE(plan.Due("stall", 2));
}

}  // namespace keypose::capture::shoot::fault_plan_test
