// keypose-landmarks suggest: its files and exit codes.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "core/io/meshes/mesh_io.h"
#include "core/io/project/landmarks_io.h"
#include "core/io/text/files.h"
#include "core/testing/folder.h"
#include "core/testing/paths.h"
#include "register/testing/limbed_bodies.h"

namespace keypose::registration::landmarks_program_test {

class LandmarksProgram : public ::testing::Test, public TestingFolder {
 protected:
  void SetUp() override {
    WriteMesh(folder_ / "a.ply", source_);
    WriteMesh(folder_ / "b.ply", target_);
  }
  int Run(const std::string& arguments) {
    const std::string command = "cd '" + folder_.string() + "' && '" + BinFolder() +
                                "/keypose-landmarks' suggest --source a.ply --target b.ply " +
                                arguments + " > log.txt 2>&1";
    const int status = std::system(command.c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  Mesh source_ = LimbedBody(kQuadruped, 3),
       target_ = Posed(LimbedBody(kQuadruped, 3, OtherTessellation()));
};

TEST_F(LandmarksProgram, WritesPairsToConfirmAndThenTheConfirmedPicks) {
  ASSERT_EQ(Run("--suggested s.json --picture s.png --panel 64"), 0)
      << ReadFile(folder_ / "log.txt");
  const auto pairs = ReadLandmarkPairs({folder_ / "s.json"}, source_, target_);
  ASSERT_EQ(pairs.size(), 12u);
  for (const LandmarkPair& pair : pairs) EXPECT_FALSE(pair.confirmed);
  EXPECT_TRUE(std::filesystem::exists(folder_ / "s.png"));
  ASSERT_EQ(Run("--suggested t.json --accept 1,3-4 --source_picks a.json --target_picks b.json"), 0)
      << ReadFile(folder_ / "log.txt");
  const auto picks = ReadLandmarkPairs({folder_ / "a.json", folder_ / "b.json"}, source_, target_);
  ASSERT_EQ(picks.size(), 3u);
  EXPECT_EQ(picks[1].name, pairs[2].name);
  EXPECT_EQ(picks[1].target.face, pairs[2].target.face);
  ASSERT_EQ(Run("--suggested u.json --landmarks t.json --count 2"), 0)
      << ReadFile(folder_ / "log.txt");
  const auto again = ReadLandmarkPairs({folder_ / "u.json"}, source_, target_);
  EXPECT_EQ(std::count_if(again.begin(), again.end(),
                          [](const LandmarkPair& pair) { return pair.confirmed; }),
            3);
  EXPECT_EQ(again.size(), 5u);
}

TEST_F(LandmarksProgram, ExitCodesAndNoHalfWrittenFiles) {
  EXPECT_EQ(Run("--suggested s.json --accept 1,99"), 2);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "s.json"));
  EXPECT_EQ(Run("--suggested s.json --source_picks a.json"), 2);
  WriteFileAtomically(folder_ / "b.ply", "ply\nnonsense");
  EXPECT_EQ(Run("--suggested s.json"), 3);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "s.json"));
}

}  // namespace keypose::registration::landmarks_program_test
