#include "core/stage/output_guard.h"

#include <gtest/gtest.h>

#include "core/io/text/files.h"
#include "core/stage/stage.h"
#include "core/testing/folder.h"
#include "core/values/size_of.h"

namespace keypose::output_guard_test {
namespace fs = std::filesystem;

struct NoOptions {
  void Describe(OptionVisitor&) {}
};

StageSpec FolderSpec() {
  return {"test",
          "1",
          "Copies photographs.",
          "Copies",
          {},
          {{"photos", "folder", "what to copy", ""}, {"list", "file", "names", "", true}},
          {{"images", "folder", "the copies", "images"},
           {"note", "file", "what was done", "note.txt", true}},
          {},
          {},
          1,
          0.1};
}

void CopyPhotographs(StageContext& stage, const NoOptions&) {
  const fs::path images = stage.Output("images");
  for (const auto& entry : fs::directory_iterator(stage.Input("photos")))
    if (entry.is_regular_file() && !entry.path().filename().string().starts_with("."))
      fs::copy_file(entry.path(), images / entry.path().filename());
  fs::create_directories(images / "masks");
  WriteFile(images / "masks/a.png", "mask");
  if (stage.Has("note")) WriteFile(stage.Output("note"), "done");
}

class OutputGuardTest : public ::testing::Test, public TestingFolder {
 protected:
  void SetUp() override {
    fs::create_directories(folder_ / "shoot");
    WriteFile(folder_ / "shoot/a.jpg", "original");
    before_ = fs::current_path();
    fs::current_path(folder_);
  }
  void TearDown() override {
    fs::current_path(before_);
    ::unsetenv("KEYPOSE_PROGRESS_FD");
  }
  int Run(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "keypose-test");
    std::vector<char*> argv;
    for (std::string& argument : arguments) argv.push_back(argument.data());
    ::testing::internal::CaptureStderr();
    const int code = RunStage<NoOptions>(SizeOf(argv), argv.data(), FolderSpec(), CopyPhotographs);
    error_ = ::testing::internal::GetCapturedStderr();
    return code;
  }
  void ExpectOriginal() const { EXPECT_EQ(ReadFile(folder_ / "shoot/a.jpg"), "original"); }
  int HiddenLeft() const {
    int count = 0;
    for (const auto& entry : fs::directory_iterator(folder_))
      count += entry.path().filename().string().starts_with(".");
    return count;
  }
  fs::path before_;
  std::string error_;
};

TEST_F(OutputGuardTest, NeverReplacesTheWorkingFolder) {
  for (const char* place : {".", "..", "/", "shoot/.."})
    for (const bool overwrite : {false, true}) {
      std::vector<std::string> arguments{"--photos", "shoot", "--images", place};
      if (overwrite) arguments.push_back("--overwrite");
      EXPECT_EQ(Run(arguments), 4) << place << ": " << error_;
      ExpectOriginal();
    }
  EXPECT_NE(error_.find("--photos"), std::string::npos) << error_;
  EXPECT_EQ(HiddenLeft(), 0);
}

TEST_F(OutputGuardTest, NeverReplacesAnInputOrWhatHoldsOne) {
  fs::create_directories(folder_ / "work/shoot");
  WriteFile(folder_ / "work/shoot/b.jpg", "b");
  fs::create_directory_symlink(folder_ / "shoot", folder_ / "link");
  for (const auto& [photos, images] : {std::pair{"shoot", "shoot"},
                                       {"shoot", "link"},
                                       {"link", "shoot"},
                                       {"work/shoot", "work"},
                                       {"work", "work/shoot"}})
    for (const bool overwrite : {false, true}) {
      std::vector<std::string> arguments{"--photos", photos, "--images", images};
      if (overwrite) arguments.push_back("--overwrite");
      EXPECT_EQ(Run(arguments), 4) << photos << " to " << images;
      ExpectOriginal();
      EXPECT_TRUE(fs::exists(folder_ / "work/shoot/b.jpg"));
    }
  WriteFile(folder_ / "names.txt", "names");
  EXPECT_EQ(
      Run({"--photos", "shoot", "--images", "out", "--list", "names.txt", "--note", "./names.txt"}),
      4);
  EXPECT_EQ(
      Run({"--photos", "shoot", "--images", "out", "--list", "names.txt", "--report", "names.txt"}),
      4);
  EXPECT_EQ(ReadFile(folder_ / "names.txt"), "names");
}

TEST_F(OutputGuardTest, ReplacesWhatItWroteAndNothingElse) {
  EXPECT_EQ(Run({"--photos", "shoot", "--images", "out"}), 0) << error_;
  EXPECT_EQ(Run({"--photos", "shoot", "--images", "out"}), 0) << error_;
  WriteFile(folder_ / "out/mine.txt", "a week of work");
  EXPECT_EQ(Run({"--photos", "shoot", "--images", "out"}), 4);
  EXPECT_NE(error_.find("mine.txt"), std::string::npos) << error_;
  EXPECT_NE(error_.find("--overwrite"), std::string::npos) << error_;
  EXPECT_EQ(ReadFile(folder_ / "out/mine.txt"), "a week of work");
  fs::remove(folder_ / "out/mine.txt");
  WriteFile(folder_ / "out/masks/a.png", "painted by hand");
  EXPECT_EQ(Run({"--photos", "shoot", "--images", "out"}), 4);
  EXPECT_EQ(ReadFile(folder_ / "out/masks/a.png"), "painted by hand");
  EXPECT_EQ(Run({"--photos", "shoot", "--images", "out", "--overwrite"}), 0) << error_;
  EXPECT_EQ(ReadFile(folder_ / "out/masks/a.png"), "mask");
}

TEST_F(OutputGuardTest, EmptyFoldersAndNewOnesAreFree) {
  fs::create_directories(folder_ / "empty");
  EXPECT_EQ(Run({"--photos", "shoot", "--images", "empty"}), 0) << error_;
  EXPECT_EQ(Run({"--photos", "shoot", "--images", "new/deep/"}), 0) << error_;
  EXPECT_TRUE(fs::exists(folder_ / "new/deep/a.jpg"));
}

TEST_F(OutputGuardTest, ALinkToAFolderStaysALink) {
  fs::create_directories(folder_ / "disk");
  fs::create_directory_symlink(folder_ / "disk", folder_ / "out");
  EXPECT_EQ(Run({"--photos", "shoot", "--images", "out"}), 0) << error_;
  EXPECT_TRUE(fs::is_symlink(folder_ / "out"));
  EXPECT_TRUE(fs::exists(folder_ / "disk/a.jpg"));
}

TEST_F(OutputGuardTest, AFileTakesNoFoldersPlaceNorAFolderAFiles) {
  WriteFile(folder_ / "file", "text");
  EXPECT_EQ(Run({"--photos", "shoot", "--images", "file", "--overwrite"}), 4);
  EXPECT_EQ(ReadFile(folder_ / "file"), "text");
  fs::create_directories(folder_ / "empty");
  EXPECT_EQ(Run({"--photos", "shoot", "--images", "out", "--note", "empty", "--overwrite"}), 4);
  EXPECT_TRUE(fs::is_directory(folder_ / "empty"));
  EXPECT_EQ(Run({"--photos", "shoot", "--images", "out", "--note", "/dev/null"}), 4);
  EXPECT_FALSE(fs::is_regular_file("/dev/null"));
  EXPECT_EQ(Run({"--photos", "shoot", "--images", "out", "--report", "/dev/null"}), 0) << error_;
  EXPECT_FALSE(fs::is_regular_file("/dev/null"));
}

TEST_F(OutputGuardTest, OutputsKeepApartFromEachOther) {
  EXPECT_EQ(Run({"--photos", "shoot", "--images", "out", "--note", "out"}), 2);
  EXPECT_EQ(Run({"--photos", "shoot", "--images", "out", "--note", "out/note.txt"}), 2);
  EXPECT_NE(error_.find("--note"), std::string::npos) << error_;
}

TEST_F(OutputGuardTest, TheRunnersFoldersHaveNoMark) {
  ::setenv("KEYPOSE_PROGRESS_FD", "999", 1);
  EXPECT_EQ(Run({"--photos", "shoot", "--images", "out"}), 0) << error_;
  int files = 0;
  for (const auto& entry : fs::directory_iterator(folder_ / "out"))
    files += entry.path().filename().string().starts_with(".");
  EXPECT_EQ(files, 0);
}

}  // namespace keypose::output_guard_test
