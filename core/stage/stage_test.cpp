#include "core/stage/stage.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <nlohmann/json.hpp>

#include "core/io/text/files.h"
#include "core/testing/folder.h"
#include "core/testing/paths.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose::stage_test {
namespace fs = std::filesystem;
using nlohmann::json;

struct TestOptions {
  int copies = 2;
  double scale = 0.5;
  std::string mode = "plain";
  bool loud = false;
  void Describe(OptionVisitor& visit) {
    visit("copies", copies, {"how often", "", 1, 9, {}});
    visit("scale", scale, {"a factor", "m", 0, 1, {}});
    visit("mode", mode, {"which way", "", -INFINITY, INFINITY, {"plain", "fancy", "fail", "bug"}});
    visit("loud", loud, {"shout"});
  }
};

StageSpec Spec() {
  return {"test",
          "1",
          "Copies a text.",
          "Copied text",
          {{"letters", "letters copied"}, {"lost", "letters lost", "share", -kAnyNumber, 0}},
          {{"text", "file", "what to copy", ""}},
          {{"copy", "file", "the copies", "copy.txt"}},
          {},
          {},
          1,
          0.1};
}

void CopyStage(StageContext& stage, const TestOptions& options) {
  std::string out;
  for (int i = 0; i < options.copies; ++i) out += ReadFile(stage.Input("text"));
  WriteFile(stage.Output("copy"), out);
  stage.Report("copies", options.copies);
  for (int i = 0; i < options.copies && options.copies > 2; ++i)  // is said once
    stage.Warn("'clay' is copied " + std::to_string(options.copies) + " times");
  stage.Verdict("clay", options.copies > 2 ? "look" : "good", "counted");
  if (options.mode == "fail") throw InputError("told to fail");
  if (options.mode == "bug") throw std::logic_error("a bug");
}

class StageTest : public ::testing::Test, public TestingFolder {
 protected:
  void SetUp() override { WriteFile(folder_ / "in.txt", "clay "); }
  int Run(std::vector<std::string> extra) {
    std::vector<std::string> arguments{"keypose-test",
                                       "--text",
                                       (folder_ / "in.txt").string(),
                                       "--copy",
                                       (folder_ / "out.txt").string(),
                                       "--report",
                                       (folder_ / "report.json").string()};
    arguments.insert(arguments.end(), extra.begin(), extra.end());
    std::vector<char*> argv;
    for (std::string& argument : arguments) argv.push_back(argument.data());
    ::testing::internal::CaptureStderr();
    const int code = RunStage<TestOptions>(SizeOf(argv), argv.data(), Spec(), CopyStage);
    error_ = ::testing::internal::GetCapturedStderr();
    return code;
  }
  int EntriesLeft() const {
    return static_cast<int>(
        std::distance(fs::directory_iterator(folder_), fs::directory_iterator{}));
  }
  std::string error_;
};

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

TEST_F(StageTest, UnexpectedExceptionIsExitCodeOne) { EXPECT_EQ(Run({"--mode", "bug"}), 1); }

TEST_F(StageTest, UsageErrorsNameTheOption) {
  EXPECT_EQ(Run({"--copies", "10"}), 2);
  EXPECT_NE(error_.find("--copies is 10, but must lie in [1, 9]"), std::string::npos) << error_;
  EXPECT_EQ(Run({"--mode", "odd"}), 2);
  EXPECT_EQ(Run({"--copeis", "3"}), 2);
  EXPECT_NE(error_.find("did you mean --copies"), std::string::npos) << error_;
}

TEST_F(StageTest, ArgumentsMayComeAfterTheStart) {
  const fs::path given = folder_ / "arguments";
  const auto run = [&](const std::string& text) {
    WriteFile(given, text);
    std::string name = "keypose-test", flag = "--await";
    char* argv[] = {name.data(), flag.data()};
    const int kept = ::dup(STDIN_FILENO), from = ::open(given.c_str(), O_RDONLY);
    ::dup2(from, STDIN_FILENO);
    const int code = RunStage<TestOptions>(2, argv, Spec(), CopyStage);
    ::dup2(kept, STDIN_FILENO);
    ::close(kept);
    ::close(from);
    return code;
  };
  std::string text;
  const std::vector<std::string> words = {
      "--text", folder_ / "in.txt", "--copy", folder_ / "out.txt", "--copies", "3"};
  for (const std::string& one : words) text += one + '\0';
  EXPECT_EQ(run(""), 0) << "nobody needs it";
  EXPECT_EQ(run(text.substr(0, text.size() - 1)), 0) << "who gave them is gone";
  EXPECT_FALSE(fs::exists(folder_ / "out.txt"));
  EXPECT_EQ(run(text), 0);
  EXPECT_EQ(ReadFile(folder_ / "out.txt"), "clay clay clay ");
  EXPECT_EQ(run(text + "--copeis" + '\0' + "3" + '\0'), 2);
}

TEST_F(StageTest, MissingInputIsAnInputError) {
  fs::remove(folder_ / "in.txt");
  EXPECT_EQ(Run({}), 3);
  EXPECT_NE(error_.find("in.txt does not exist"), std::string::npos);
}

TEST_F(StageTest, DescribesItself) {
  std::string name = "keypose-test", flag = "--describe";
  char* argv[] = {name.data(), flag.data()};
  ::testing::internal::CaptureStdout();
  EXPECT_EQ(RunStage<TestOptions>(2, argv, Spec(), CopyStage), 0);
  const json description = json::parse(::testing::internal::GetCapturedStdout());
  EXPECT_EQ(description["stage"], "test");
  EXPECT_EQ(description["inputs"][0]["name"], "text");
  EXPECT_EQ(description["outputs"][0]["file"], "copy.txt");
  EXPECT_EQ(description["options"][0]["default"], 2);
  EXPECT_EQ(description["options"][1]["unit"], "m");
  EXPECT_EQ(description["title"], "Copied text");
  EXPECT_EQ(description["measurements"],
            json::parse(R"([{"key": "letters", "label": "letters copied", "unit": ""},
                            {"key": "lost", "label": "letters lost", "unit": "share",
                             "good": {"max": 0}}])"));
}

/// An option that no range can describe.
struct PairedOptions {
  int low = 1, high = 2;
  void Describe(OptionVisitor& visit) {
    visit("low", low, {"at most high", "", 0, 9, {}});
    visit("high", high, {"at least low", "", 0, 9, {}});
  }
  std::vector<std::string> Problems() const {
    if (low > high) return {"low is above high"};
    return {};
  }
};

TEST_F(StageTest, OptionsAreCheckedWithoutPorts) {
  const auto check = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"keypose-test", "--check_options"});
    std::vector<char*> argv;
    for (std::string& argument : arguments) argv.push_back(argument.data());
    ::testing::internal::CaptureStderr();
    const int code = RunStage<PairedOptions>(SizeOf(argv), argv.data(), Spec(),
                                             [](StageContext&, const PairedOptions&) { FAIL(); });
    error_ = ::testing::internal::GetCapturedStderr();
    return code;
  };
  EXPECT_EQ(check({}), 0);
  EXPECT_EQ(check({"--low", "2"}), 0);
  EXPECT_EQ(check({"--low", "3"}), 2);
  EXPECT_EQ(error_, "keypose test: error: low is above high\n");
}

std::string HelpOf(const StageSpec& spec) {
  std::string name = "keypose-test", flag = "--help";
  char* argv[] = {name.data(), flag.data()};
  ::testing::internal::CaptureStdout();
  EXPECT_EQ(RunStage<TestOptions>(2, argv, spec, CopyStage), 0);
  return ::testing::internal::GetCapturedStdout();
}

TEST_F(StageTest, HelpTellsRangesOfNumbersOnly) {
  const std::string help = HelpOf(Spec());
  EXPECT_NE(help.find("how often, 1 to 9"), std::string::npos) << help;
  EXPECT_NE(help.find("a factor [m], 0 to 1"), std::string::npos) << help;
  EXPECT_NE(help.find("--mode plain|fancy|fail|bug=plain"), std::string::npos) << help;
  EXPECT_NE(help.find("--loud true|false=false"), std::string::npos) << help;
  EXPECT_EQ(help.find("-inf"), std::string::npos) << help;
  EXPECT_EQ(help.find("shout,"), std::string::npos) << help;
}

TEST_F(StageTest, HelpHasPortsThenCommonOptionsThenTheRest) {
  StageSpec spec = Spec();
  spec.common = {"mode"};
  const std::string help = HelpOf(spec);
  std::size_t before = 0;
  for (const char* part : {"--text", "--copy", "Common options", "--mode", "Further options",
                           "--copies", "--report", "--help"}) {
    const std::size_t at = help.find(part, before);
    ASSERT_NE(at, std::string::npos) << part << " is missing or too early in\n" << help;
    before = at;
  }
}

TEST_F(StageTest, CommonOptionThatIsNoneIsABug) {
  StageSpec spec = Spec();
  spec.common = {"colour"};
  std::string name = "keypose-test", flag = "--help";
  char* argv[] = {name.data(), flag.data()};
  ::testing::internal::CaptureStderr();
  EXPECT_EQ(RunStage<TestOptions>(2, argv, spec, CopyStage), 1);
  ::testing::internal::GetCapturedStderr();
}

TEST_F(StageTest, ActionIsDoneInsteadOfARunAndNeedsNoPort) {
  const std::vector<StageAction<TestOptions>> actions = {
      {"card", "write a card and stop",
       [](const fs::path& file, const TestOptions& o) { WriteFile(file, o.mode); }}};
  const auto run = [&](std::vector<std::string> arguments) {
    std::vector<char*> argv;
    for (std::string& argument : arguments) argv.push_back(argument.data());
    ::testing::internal::CaptureStderr();
    const int code = RunStage<TestOptions>(SizeOf(argv), argv.data(), Spec(), CopyStage, actions);
    error_ = ::testing::internal::GetCapturedStderr();
    return code;
  };
  const std::string card = (folder_ / "card.txt").string(), text = (folder_ / "in.txt").string();
  EXPECT_EQ(run({"keypose-test", "--card", card, "--mode", "fancy"}), 0) << error_;
  EXPECT_EQ(ReadFile(card), "fancy");
  EXPECT_EQ(run({"keypose-test", "--card", card, "--copies", "10"}), 2);
  EXPECT_EQ(run({"keypose-test", "--card", card, "--text", text}), 2);
  EXPECT_NE(error_.find("does not accept --text"), std::string::npos) << error_;
  EXPECT_EQ(run({"keypose-test"}), 2);
}

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

/// Starts a program that is stuck, sends signals, and returns its exit code.
int EndStuck(const fs::path& folder, const std::vector<int>& signals) {
  const std::string text = folder / "in.txt", copy = folder / "out.txt";
  const pid_t child = fork();
  if (child == 0) {
    execl((BinFolder() + "/testing/core_stuck_stage").c_str(), "stuck", "--text", text.c_str(),
          "--copy", copy.c_str(), nullptr);
    _exit(127);
  }
  while (!fs::exists(folder / "stuck") && waitpid(child, nullptr, WNOHANG) == 0) usleep(1000);
  for (const int signal : signals) kill(child, signal), usleep(20000);
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

TEST_F(StageTest, SignalEndsItInACallThatCannotBeAskedAndLeavesNothing) {
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_EQ(EndStuck(folder_, {SIGTERM}), 130);
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(100)) << "of 300";
  fs::remove(folder_ / "stuck");
  for (const fs::directory_entry& entry : fs::directory_iterator(folder_))
    EXPECT_EQ(entry.path().filename(), "in.txt") << "litter";
}

TEST_F(StageTest, SecondSignalEndsItAtOnce) {
  EXPECT_EQ(EndStuck(folder_, {SIGINT, SIGINT}), 130);
  EXPECT_FALSE(fs::exists(folder_ / "out.txt"));
}

}  // namespace keypose::stage_test
