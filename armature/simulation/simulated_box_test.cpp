#include "armature/simulation/simulated_box.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>

#include "armature/controller/testing/arm.h"
#include "core/testing/folder.h"

namespace keypose::armature::simulated_box_test {

TEST(SimulatedBox, ShaftsTurnNoFasterThanAsked) {
  const Armature arm = Arm();
  const TestingFolder folder;
  SimulationOptions options;
  options.speed_rev_s = 10;
  SimulatedBox box(arm, folder.path() / "port", options);
  EXPECT_TRUE(box.at_rest());
  const auto begin = std::chrono::steady_clock::now();
  box.MoveTo({2.5, 0});  // at a scale of 25: ten turns of the shaft, one second
  for (int i = 0; i < 1000 && !box.at_rest(); ++i) usleep(5000);
  EXPECT_TRUE(box.at_rest());
  // Its thread may have slept for a while before it was asked.
  EXPECT_GT(std::chrono::steady_clock::now() - begin, std::chrono::milliseconds(500));
}

TEST(SimulatedBox, AFaultThatIsPlannedForAFrameComesOnce) {
  const Armature arm = Arm();
  const TestingFolder folder;
  SimulationOptions options;
  options.faults = {{FaultKind::kPower, -1, 3}};
  SimulatedBox box(arm, folder.path() / "port", options);
  const int boot = box.boot();
  box.BeginFrame(2);
  EXPECT_EQ(box.boot(), boot);
  box.BeginFrame(3);
  EXPECT_EQ(box.boot(), boot + 1);
  box.BeginFrame(3);
  EXPECT_EQ(box.boot(), boot + 1);
}

TEST(SimulatedBox, ItsPortIsALinkThatGoesWithIt) {
  const Armature arm = Arm();
  const TestingFolder folder;
  const std::filesystem::path port = folder.path() / "port";
  {
    const SimulatedBox box(arm, port);
    EXPECT_TRUE(std::filesystem::is_symlink(port));
  }
  EXPECT_FALSE(std::filesystem::is_symlink(port));
}

}  // namespace keypose::armature::simulated_box_test
