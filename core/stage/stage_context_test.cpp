#include "core/stage/stage_context.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/io/text/files.h"
#include "core/stage/testing/copy_stage.h"

namespace keypose::stage_context_test {

namespace fs = std::filesystem;
using nlohmann::json;

TEST_F(StageTest, WritesItsOutputAndReport) {
  EXPECT_EQ(Run({"--copies", "3"}), 0);
  EXPECT_EQ(ReadFile(folder_ / "out.txt"), "clay clay clay ");
  const json report = json::parse(ReadFile(folder_ / "report.json"));
  EXPECT_EQ(report["stage"], "test");
  EXPECT_EQ(report["options"]["copies"], 3);
  EXPECT_EQ(report["options"]["scale"], 0.5);
  EXPECT_EQ(report["measurements"]["copies"], 3);
  EXPECT_GT(report["peak_bytes"], 0);
  EXPECT_EQ(report["warnings"], json::array({"'clay' is copied 3 times"}));
  EXPECT_EQ(report["verdicts"][0]["grade"], "look");
  EXPECT_NE(error_.find("warning: 'clay' is copied 3 times"), std::string::npos);
}

TEST_F(StageTest, FailureLeavesNoOutputAndNoLitter) {
  EXPECT_EQ(Run({"--mode", "fail"}), 3);
  EXPECT_FALSE(fs::exists(folder_ / "out.txt"));
  EXPECT_EQ(EntriesLeft(), 1);
  EXPECT_NE(error_.find("told to fail"), std::string::npos);
}

TEST_F(StageTest, FailureKeepsAnEarlierOutput) {
  ASSERT_EQ(Run({}), 0);
  EXPECT_EQ(Run({"--mode", "fail"}), 3);
  EXPECT_EQ(ReadFile(folder_ / "out.txt"), "clay clay ");
}

}  // namespace keypose::stage_context_test
