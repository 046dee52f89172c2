#include "core/stage/stage.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/io/text/files.h"
#include "core/stage/testing/copy_stage.h"
#include "core/values/size_of.h"

namespace keypose::stage_test {

namespace fs = std::filesystem;
using nlohmann::json;

TEST_F(StageTest, UnexpectedExceptionIsExitCodeOne) { EXPECT_EQ(Run({"--mode", "bug"}), 1); }

TEST_F(StageTest, UsageErrorsNameTheOption) {
  EXPECT_EQ(Run({"--copies", "10"}), 2);
  EXPECT_NE(error_.find("--copies is 10, but must lie in [1, 9]"), std::string::npos) << error_;
  EXPECT_EQ(Run({"--mode", "odd"}), 2);
  EXPECT_EQ(Run({"--copeis", "3"}), 2);
  EXPECT_NE(error_.find("did you mean --copies"), std::string::npos) << error_;
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

}  // namespace keypose::stage_test
