// What a reader tells of a controller whose cable and power fail.
#include "armature/controller/armature_reader.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <memory>
#include <thread>

#include "armature/controller/steady_clock.h"
#include "armature/controller/testing/simulated_joint.h"
#include "armature/description/description_file.h"
#include "core/io/text/serial_port.h"
#include "core/testing/folder.h"
#include "core/values/errors.h"

namespace keypose::armature::armature_reader_test {

/// Reads until it has told of this, and adds the codes of all that it tells.
void ReadUntil(ArmatureReader& reader, const std::string& code, std::vector<std::string>* codes) {
  for (int i = 0; i < 1000; ++i, usleep(5000)) {
    reader.Poll();
    for (const ReaderEvent& event : reader.TakeEvents()) codes->push_back(event.code);
    if (std::find(codes->begin(), codes->end(), code) != codes->end()) return;
  }
}

TEST(ArmatureReader, AControllerThatLostItsPowerWithItsCableSaysSoLast) {
  const Armature arm = OneJoint();
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
  EXPECT_THAT(codes, ::testing::ElementsAre("cable-out", "cable-back", "power-lost"));
}

std::vector<std::string> CodesOf(ArmatureReader& reader, double seconds) {
  std::vector<std::string> codes;
  for (const double until = SteadySeconds() + seconds; SteadySeconds() < until; usleep(5000)) {
    reader.Poll();
    for (const ReaderEvent& event : reader.TakeEvents()) codes.push_back(event.code);
  }
  return codes;
}

TEST(ArmatureReader, PowerThatWasLostIsToldOnceAndNotAgainByTheNextProgram) {
  const Armature arm = OneJoint();
  const TestingFolder folder;
  PortOptions port;
  port.device = folder.path() / "port";
  SimulatedBox box(arm, port.device);
  Calibration kept{7, std::vector<SensorState>(1)};  // of a controller before its power-up
  {
    ArmatureReader reader(arm, port, kept);
    EXPECT_THAT(CodesOf(reader, 0.1), ::testing::ElementsAre("power-lost"));
    kept = reader.calibration();
  }
  ArmatureReader next(arm, port, kept);
  EXPECT_THAT(CodesOf(next, 0.1), ::testing::IsEmpty());
}

TEST(ArmatureReader, ACounterThatLostItsCountStandsAsItDidAndIsNotCalledWellAgain) {
  const Armature arm = OneJoint();
  const TestingFolder folder;
  PortOptions port;
  port.device = folder.path() / "port";
  SimulatedBox box(arm, port.device);
  auto reader = std::make_unique<ArmatureReader>(arm, port, Calibration{});
  reader->ResetCounters();
  box.MoveTo({0.5});
  EXPECT_THAT(CodesOf(*reader, 0.4), ::testing::IsEmpty());
  const double before = reader->Poll().values[0];
  EXPECT_NEAR(before, 0.5, 1e-3);
  box.Make({FaultKind::kLost, 0});
  EXPECT_THAT(CodesOf(*reader, 0.6), ::testing::ElementsAre("sensor-jumped", "sensor-lost-count"));
  EXPECT_EQ(reader->last().values[0], before);
  EXPECT_TRUE(reader->last().held.empty());
  reader->SetValue(0, 0);  // a person has put it there
  const Calibration kept = reader->calibration();
  reader.reset();
  ArmatureReader next(arm, port, kept);
  EXPECT_THAT(CodesOf(next, 0.1), ::testing::IsEmpty());
}

/// As a port is whose cable was just plugged in.
void LetDtrFallAtTheEnd(const std::string& device) {
  const int fd = open(device.c_str(), O_RDWR | O_NOCTTY);
  termios settings = {};
  ASSERT_EQ(tcgetattr(fd, &settings), 0);
  settings.c_cflag |= HUPCL;
  ASSERT_EQ(tcsetattr(fd, TCSANOW, &settings), 0);
  close(fd);
}

TEST(ArmatureReader, ABoardThatBeginsAgainWhenItsPortIsOpenedIsNotSpokenToAtFirst) {
  const Armature arm = OneJoint();
  const TestingFolder folder;
  PseudoTerminal board;
  const std::string device = (folder.path() / "port").string();
  board.Open(device);
  LetDtrFallAtTheEnd(device);
  PortOptions port;
  port.device = device;
  port.start_s = 0.3;
  port.link = {0.01, 1};
  const double begin = SteadySeconds();
  // Nobody answers on this one; the second time DTR is up already.
  EXPECT_THROW(ArmatureReader(arm, port, {}), ToolError);
  const double first = SteadySeconds();
  EXPECT_GE(first - begin, 0.3);
  EXPECT_THROW(ArmatureReader(arm, port, {}), ToolError);
  EXPECT_LT(SteadySeconds() - first, 0.3);
}

/// Between the host and a box: a board whose boot loader waits on as long as something comes.
class BoardWithBootLoader {
 public:
  BoardWithBootLoader(const std::filesystem::path& host, const std::filesystem::path& box) {
    host_.Open(host);
    box_.Open(box, 1000000);
    thread_ = std::thread([this] {
      while (!ends_) Pass();
    });
  }
  ~BoardWithBootLoader() {
    ends_ = true;
    thread_.join();
  }
  void PressReset() { starts_until_s_ = SteadySeconds() + kLoader_s; }

 private:
  static constexpr double kLoader_s = 0.2;
  void Pass() {
    const std::string asked = host_.Read(0.001);
    if (SteadySeconds() < starts_until_s_) {
      if (!asked.empty()) PressReset();
      return;
    }
    if (asked.empty()) return;
    box_.Write(asked);
    for (std::string reply = box_.Read(0.02); !reply.empty(); reply = box_.Read(0.002))
      host_.Write(reply);
  }
  PseudoTerminal host_;
  SerialPort box_;
  std::atomic<bool> ends_ = false;
  std::atomic<double> starts_until_s_ = 0;
  std::thread thread_;
};

TEST(ArmatureReader, ABoardsResetButtonIsNoEndAsItsBootLoaderIsLeftAlone) {
  const Armature arm = OneJoint();
  const TestingFolder folder;
  PortOptions port;
  port.device = folder.path() / "board";
  port.retry_s = 0.02;
  port.start_s = 0.4;
  port.link = {0.05, 3};
  SimulatedBox box(arm, folder.path() / "box");
  BoardWithBootLoader board(port.device, folder.path() / "box");
  ArmatureReader reader(arm, port, {});
  reader.ResetCounters();
  board.PressReset();
  std::vector<std::string> codes;
  ReadUntil(reader, "cable-back", &codes);
  EXPECT_THAT(codes, ::testing::ElementsAre("silent", "cable-back"));
}

}  // namespace keypose::armature::armature_reader_test
