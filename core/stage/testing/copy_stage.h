// A stage that copies its input, and its run in a folder of its own.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <iterator>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/io/text/files.h"
#include "core/stage/stage.h"
#include "core/testing/folder.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose {

namespace fs = std::filesystem;

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

inline StageSpec Spec() {
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

inline void CopyStage(StageContext& stage, const TestOptions& options) {
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

}  // namespace keypose
