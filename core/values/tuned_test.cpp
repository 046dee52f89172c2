// Tuned constants in builds for bench/sensitivity.py. Constants are made before main(), so the
// tests start this program again with the variables set: as a child it prints what it is asked for.
#include "core/values/tuned.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <string>
#include <thread>

#include "core/testing/folder.h"

namespace keypose {
namespace {

struct TestTuning {
  KEYPOSE_TUNED(double, kShare, 15.0 / 60);
  KEYPOSE_TUNED(int, kRounds, 3);
  KEYPOSE_TUNED(float, kUnread, 2.5F);
};

std::string TextOf(const fs::path& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// Runs the child "share", "both" or "crash" with these variables; what it printed is in out.txt.
int RunChild(const std::string& child, const std::string& variables, const fs::path& folder) {
  const std::string self = fs::read_symlink("/proc/self/exe").string();
  return std::system(("KEYPOSE_TUNED_CHILD=" + child + " " + variables + " '" + self + "' > '" +
                      (folder / "out.txt").string() + "' 2>/dev/null")
                         .c_str());
}

/// std::max takes references, and another thread may be the first to read.
void PrintShare() {
  std::thread([] { std::printf("%g\n", std::max(TestTuning::kShare, 0.1)); }).join();
}

void Crash() {
  volatile std::uintptr_t nowhere = 8;
  *reinterpret_cast<volatile int*>(nowhere) = 1;
}

class Tuned : public ::testing::Test, public TestingFolder {
 protected:
  std::string Out() const { return TextOf(folder_ / "out.txt"); }
  std::string Read() const { return TextOf(folder_ / "read.txt"); }
  std::string Log() const { return "KEYPOSE_TUNED_READ='" + (folder_ / "read.txt").string() + "'"; }
};

TEST_F(Tuned, AVariableReplacesTheConstantOfThisFileAndName) {
  ASSERT_EQ(RunChild("both", "", folder_), 0);
  EXPECT_EQ(Out(), "0.25\n3\n");
  ASSERT_EQ(RunChild("both", "KEYPOSE_TUNED=core/values/tuned_test.cpp:kRounds=7", folder_), 0);
  EXPECT_EQ(Out(), "0.25\n7\n");
  ASSERT_EQ(RunChild("both", "KEYPOSE_TUNED=core/values/tuned_test.cpp:kShare=0.5", folder_), 0);
  EXPECT_EQ(Out(), "0.5\n3\n");
  ASSERT_EQ(RunChild("both", "KEYPOSE_TUNED=core/other.cpp:kShare=0.5", folder_), 0);
  EXPECT_EQ(Out(), "0.25\n3\n");
}

TEST_F(Tuned, TheFirstReadOfAConstantIsNotedOnce) {
  ASSERT_EQ(RunChild("share", Log(), folder_), 0);
  EXPECT_EQ(Out(), "0.25\n");
  EXPECT_TRUE(Read().ends_with("core/values/tuned_test.cpp:kShare\n")) << Read();
  EXPECT_EQ(std::ranges::count(Read(), '\n'), 1);
  ASSERT_EQ(RunChild("both", Log(), folder_), 0);  // appends
  EXPECT_EQ(Out(), "0.25\n3\n");
  EXPECT_TRUE(Read().ends_with("core/values/tuned_test.cpp:kRounds\n")) << Read();
  EXPECT_EQ(std::ranges::count(Read(), '\n'), 3);
}

TEST_F(Tuned, AFaultOfTheProgramItselfStillEndsIt) {
  EXPECT_NE(RunChild("crash", Log(), folder_), 0);
  EXPECT_EQ(Read(), "");
}

}  // namespace
}  // namespace keypose

int main(int argc, char** argv) {
  const char* child = std::getenv("KEYPOSE_TUNED_CHILD");
  if (child == nullptr) {
    ::testing::InitGoogleTest(&argc, argv);
    return RUN_ALL_TESTS();
  }
  const std::string name = child;
  if (name == "crash") keypose::Crash();
  keypose::PrintShare();
  if (name == "both") std::printf("%d\n", keypose::TestTuning::kRounds);
  return 0;
}
