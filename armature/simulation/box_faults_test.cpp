#include "armature/simulation/box_faults.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "armature/controller/testing/arm.h"
#include "core/values/errors.h"

namespace keypose::armature::box_faults_test {

using ::testing::HasSubstr;

std::string MessageOf(const std::string& text) {
  try {
    ParseFaults(text, Arm());
  } catch (const UsageError& error) {
    return error.what();
  }
  return "";
}

TEST(ParseFaults, TakesKindJointAndFrame) {
  const auto faults = ParseFaults("drop@5,stuck:a@20,power@0", Arm());
  ASSERT_EQ(faults.size(), 3u);
  EXPECT_EQ(faults[0].kind, FaultKind::kDrop);
  EXPECT_EQ(faults[0].sensor, -1);
  EXPECT_EQ(faults[0].frame, 5);
  EXPECT_EQ(faults[1].kind, FaultKind::kStuck);
  EXPECT_EQ(faults[1].sensor, 1);  // the description gives joint a sensor 1
  EXPECT_EQ(faults[2].kind, FaultKind::kPower);
  EXPECT_TRUE(ParseFaults("", Arm()).empty());
}

TEST(ParseFaults, SaysWhatIsWrong) {
  EXPECT_THAT(MessageOf("dorp@5"), HasSubstr("did you mean 'drop'"));
  EXPECT_THAT(MessageOf("stuck@5"), HasSubstr("needs a joint"));
  EXPECT_THAT(MessageOf("stuck:bb@5"), HasSubstr("did you mean 'b'"));
  for (const char* text : {"drop", "drop@", "drop@x", "drop@-1", "drop@5x"})
    EXPECT_THAT(MessageOf(text), HasSubstr("needs the number of a frame")) << text;
}

}  // namespace keypose::armature::box_faults_test
