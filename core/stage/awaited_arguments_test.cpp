#include "core/stage/awaited_arguments.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "core/io/text/files.h"
#include "core/stage/stage.h"
#include "core/stage/testing/copy_stage.h"

namespace keypose::awaited_arguments_test {

namespace fs = std::filesystem;

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

}  // namespace keypose::awaited_arguments_test
