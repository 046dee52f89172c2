#include <gtest/gtest.h>

#include "core/io/text/files.h"
#include "core/stage/stage.h"
#include "core/stage/testing/copy_stage.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose::tools_test {

namespace fs = std::filesystem;

void ToolStage(StageContext& stage, const TestOptions& options) {
  const std::string output =
      RunTool(stage, options.loud ? "no-such-program" : "sh",
              {"-c", options.copies == 9 ? "echo broken; exit 4" : "echo fine"});
  WriteFile(stage.Output("copy"), output);
}

TEST_F(StageTest, ExternalToolsFailWithExitCodeFive) {
  const auto run = [&](const char* flag, const char* value) {
    std::vector<std::string> arguments{"keypose-test",
                                       "--text",
                                       (folder_ / "in.txt").string(),
                                       "--copy",
                                       (folder_ / "out.txt").string(),
                                       flag,
                                       value};
    std::vector<char*> argv;
    for (std::string& argument : arguments) argv.push_back(argument.data());
    ::testing::internal::CaptureStderr();
    const int code = RunStage<TestOptions>(SizeOf(argv), argv.data(), Spec(), ToolStage);
    error_ = ::testing::internal::GetCapturedStderr();
    return code;
  };
  EXPECT_EQ(run("--copies", "1"), 0);
  EXPECT_EQ(ReadFile(folder_ / "out.txt"), "fine\n");
  EXPECT_EQ(run("--copies", "9"), 5);
  EXPECT_NE(error_.find("broken"), std::string::npos);
  EXPECT_EQ(run("--loud", "true"), 5);
  EXPECT_NE(error_.find("not installed"), std::string::npos);
}

TEST_F(StageTest, ToolThatFailsToSayItsVersionHasNone) {
  const auto version_of = [&](const std::string& script) {
    WriteFile(folder_ / "tool", "#!/bin/sh\n" + script + "\n");
    fs::permissions(folder_ / "tool", fs::perms::owner_all);
    ::setenv("KEYPOSE_TOOL", (folder_ / "tool").c_str(), 1);
    return ToolVersion("tool");
  };
  EXPECT_EQ(version_of("echo tool 2.1"), "tool 2.1");
  EXPECT_THROW(version_of("echo cannot allocate memory; exit 1"), ToolError)
      << "else its complaint would enter fingerprints";
  EXPECT_THROW(version_of("kill -9 $$"), ToolError);
  EXPECT_THROW(version_of("true"), ToolError);
  ::unsetenv("KEYPOSE_TOOL");
}

}  // namespace keypose::tools_test
