// What `check`, `edit` and `bake` say of a take that was recorded with another description.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>

#include "core/io/text/files.h"
#include "core/testing/folder.h"
#include "core/testing/paths.h"

namespace keypose::armature::take_fit_test {

using ::testing::HasSubstr;
using ::testing::Not;

/// An arm of three joints, of which the last may have been taken out of the description.
std::string Arm(bool has_wrist) {
  const std::string hand = "node { name hand length 1 }";
  return "node { name base node { name shoulder axis 1 0 0 sensor 0 scale 25 node { name upper "
         "length 1 node { name elbow axis 1 0 0 sensor 1 scale 25 node { name lower length 1 " +
         (has_wrist ? "node { name wrist axis 1 0 0 sensor 2 scale 25 " + hand + " }" : hand) +
         " } } } } }\n";
}

class TakeFit : public ::testing::Test {
 protected:
  TakeFit() {
    WriteFile(folder_.path() / "arm.txt", Arm(true));
    WriteFile(folder_.path() / "fewer.txt", Arm(false));
    WriteFile(folder_.path() / "chains.txt",
              "anchor base physical base computer base\nanchor hand physical hand computer hand\n"
              "chain arm from base to hand\n");
    WriteFile(folder_.path() / "curves.json",
              R"({"schema":1,"kind":"armature curves","fps":24,"step":2,"frames":2,"joints":{
                "shoulder":{"sensor":0,"unit":"rad","values":[0,0.5]},
                "elbow":{"sensor":1,"unit":"rad","values":[0,0.25]},
                "wrist":{"sensor":2,"unit":"rad","values":[0,1]}}})");
    WriteFile(folder_.path() / "edits.txt", "hold elbow 0-1\n");
  }
  /// @return the exit code; what it printed is in `said_`
  int Run(const std::string& command, const std::string& description) {
    const std::string line = "cd " + folder_.path().string() + " && " + BinFolder() +
                             "/keypose-armature " + command + " --description " + description +
                             " --curves curves.json > said.txt 2>&1";
    const int status = std::system(line.c_str());
    said_ = ReadFile(folder_.path() / "said.txt");
    return WEXITSTATUS(status);
  }
  const TestingFolder folder_;
  std::string said_;
};

TEST_F(TakeFit, AJointThatIsGoneFromTheDescriptionIsNamedByAllThatReadTheTake) {
  for (const std::string command : {"check", "edit --edits edits.txt --take fewer_take",
                                    "bake --chains chains.txt --frames f"}) {
    EXPECT_EQ(Run(command, "fewer.txt"), 0) << said_;
    EXPECT_THAT(said_, HasSubstr("the take has a joint 'wrist', which the description has not"))
        << command;
  }
  for (const std::string command : {"check", "edit --edits edits.txt --take whole_take",
                                    "bake --chains chains.txt --frames g"}) {
    EXPECT_EQ(Run(command, "arm.txt"), 0) << said_;
    EXPECT_THAT(said_, Not(HasSubstr("left out"))) << command;
  }
}

TEST_F(TakeFit, CheckNamesAJointThatTheTakeHasNot) {
  EXPECT_EQ(Run("check", "arm.txt"), 0) << said_;
  EXPECT_THAT(said_,
              HasSubstr("the take fits: 2 recorded frames, 2 film frames each, 24 a second"));
  std::string other = Arm(true);
  other.replace(other.find("elbow"), 5, "knee");
  WriteFile(folder_.path() / "other.txt", other);
  EXPECT_EQ(Run("check", "other.txt"), 3);
  EXPECT_THAT(said_, HasSubstr("has no joint 'knee', but 'elbow', which the description has not"));
}

}  // namespace keypose::armature::take_fit_test
