// What a reader tells of a controller whose cable and power fail.
#include "armature/controller/armature_reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>

#include "armature/description/description_file.h"
#include "armature/simulation/simulated_box.h"
#include "core/io/testing_folder.h"

namespace keypose::armature {
namespace {

/// Reads until it has told of this, and adds the codes of all that it tells.
void ReadUntil(ArmatureReader& reader, const std::string& code, std::vector<std::string>* codes) {
  for (int i = 0; i < 1000; ++i, usleep(5000)) {
    reader.Poll();
    for (const ReaderEvent& event : reader.TakeEvents()) codes->push_back(event.code);
    if (std::find(codes->begin(), codes->end(), code) != codes->end()) return;
  }
}

TEST(ArmatureReader, AControllerThatLostItsPowerWithItsCableSaysSoLast) {
  const Armature arm =
      DescriptionFile::Parse("node { name a axis 1 0 0 sensor 0 scale 25 }", "arm.txt").armature();
  const TestingFolder folder;
  PortOptions port;
  port.device = folder.path() / "port";
  port.retry_s = 0.02;
  SimulationOptions options;
  options.unplugged_s = 0.3;
  SimulatedBox box(arm, port.device, options);
  ArmatureReader reader(arm, port, {});
  EXPECT_TRUE(reader.TakeEvents().empty());
  std::vector<std::string> codes;
  box.Make({FaultKind::kUnplug});
  ReadUntil(reader, "cable-out", &codes);
  box.Make({FaultKind::kPower});
  ReadUntil(reader, "cable-back", &codes);
  EXPECT_THAT(codes, testing::ElementsAre("cable-out", "cable-back", "power-lost"));
}

}  // namespace
}  // namespace keypose::armature
