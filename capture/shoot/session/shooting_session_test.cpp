#include "capture/shoot/session/shooting_session.h"

#include <gphoto2/gphoto2-port-result.h>
#include <gphoto2/gphoto2-result.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <deque>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>

#include "capture/shoot/devices/device_fault.h"
#include "capture/shoot/devices/folder_camera.h"
#include "core/io/pictures/image_io.h"
#include "core/io/text/files.h"
#include "core/testing/folder.h"
#include "core/values/errors.h"

namespace keypose::capture::shoot::shooting_session_test {

namespace fs = std::filesystem;
using nlohmann::json;

/// Answers events as a test says.
class Script final : public Conversation {
 public:
  explicit Script(std::function<std::vector<Command>(const json&)> reply)
      : reply_(std::move(reply)) {}
  void Tell(const json& event) override {
    events.push_back(event);
    for (Command& command : reply_(event)) commands_.push_back(std::move(command));
  }
  std::optional<Command> Hear(double timeout_s) override {
    if (commands_.empty()) {
      ::usleep(static_cast<useconds_t>(1e6 * std::min(timeout_s, 0.01)));
      return std::nullopt;
    }
    Command next = commands_.front();
    commands_.pop_front();
    return next;
  }
  bool Over() const override { return false; }
  bool Interrupted() const override { return false; }
  int Count(const std::string& event, const std::string& key = "",
            const std::string& value = "") const {
    return static_cast<int>(std::count_if(events.begin(), events.end(), [&](const json& e) {
      return e.at("event") == event && (key.empty() || e.value(key, "") == value);
    }));
  }
  std::vector<json> events;

 private:
  std::function<std::vector<Command>(const json&)> reply_;
  std::deque<Command> commands_;
};

Command Of(Command::Kind kind) {
  Command command;
  command.kind = kind;
  return command;
}

std::vector<Command> DoneWhenAsked(const json& event) {
  if (event.at("event") != "ask") return {};
  return {Of(Command::Kind::kGoOn)};
}

void WritePicture(const fs::path& file, int shade) {
  const fs::path picture = file.parent_path() / ".picture.jpg";
  WriteImage(picture, Image8(64, 48, 3, static_cast<std::uint8_t>(shade)));
  fs::rename(picture, file);
}

/// Takes plain grey pictures.
class GreyCamera : public CameraDevice {
 public:
  void Connect(Patience&) override {}
  std::string Name() const override { return "grey"; }
  Exposure Take(const fs::path& into, bool, Patience&) override {
    if (fail) fail();
    WritePicture(into / "A.JPG", 60 + releases++);
    return {{into / "A.JPG"}, std::nullopt};
  }
  std::optional<Exposure> Arrived(const fs::path& into, Patience&) override {
    if (!button) return std::nullopt;
    button = false;
    WritePicture(into / "B.JPG", 200);
    return Exposure{{into / "B.JPG"}, std::nullopt};
  }
  int releases = 0;
  bool button = false;
  std::function<void()> fail;
};

struct FixedClock final : WallClock {
  std::int64_t Now() const override { return 1714744999; }
};

class SessionTest : public ::testing::Test, public TestingFolder {
 protected:
  SessionTest() {
    options_.project = project_;
    options_.pose = "rest";
    options_.plan = {.rings_deg = {12}, .angles = 3};
    options_.plan_given = true;
    options_.turntable_name = "none";
    options_.retry_s = 0.01;
  }
  bool Run(CameraDevice& camera, Conversation& talk) {
    return RunShootingSession(options_, {camera, nullptr, talk, clock_, {}, {}});
  }
  json SideFileJson(const std::string& pose = "rest") const {
    return json::parse(ReadFile(project_ / "photos" / pose / "shoot.json"));
  }
  const fs::path project_ = path();
  ShootingOptions options_;
  FixedClock clock_;
};

TEST_F(SessionTest, AsksForEachTurnByHandAndShootsAfterIt) {
  GreyCamera camera;
  Script talk(DoneWhenAsked);
  EXPECT_TRUE(Run(camera, talk));
  EXPECT_EQ(talk.Count("ask", "ask", "turn"), 3);  // 120, 240, and back to 0
  EXPECT_EQ(talk.Count("ask", "ask", "camera-height"), 1);
  EXPECT_EQ(camera.releases, 4);  // the last one only to see whether the figure moved
  EXPECT_EQ(SideFileJson().at("photographs").at("r1_a120").at("time"), "2024-05-03T14:03:19Z");
}

TEST_F(SessionTest, TakesThePhotographOfTheCamerasOwnButton) {
  GreyCamera camera;
  Script talk([&](const json& event) -> std::vector<Command> {
    if (event.at("event") != "ask") return {};
    if (event.value("angle_deg", 0.0) == 120) {
      camera.button = true;
      return {};
    }
    return {Of(Command::Kind::kGoOn)};
  });
  EXPECT_TRUE(Run(camera, talk));
  EXPECT_EQ(camera.releases, 3);
  EXPECT_NEAR(SideFileJson().at("photographs").at("r1_a120").at("exposure").get<double>(), 200, 1);
}

TEST_F(SessionTest, TellsAFaultOnceAndGoesOnByItself) {
  GreyCamera camera;
  int failures = 3;
  camera.fail = [&] {
    if (failures-- > 0) throw DeviceFault("camera-gone", "the camera is gone", "plug it in", false);
  };
  Script talk(DoneWhenAsked);
  EXPECT_TRUE(Run(camera, talk));
  EXPECT_EQ(talk.Count("fault", "fault", "camera-gone"), 1);
  EXPECT_EQ(talk.Count("recovered"), 1);
}

TEST_F(SessionTest, AsksForAHandWhereOneIsNeeded) {
  GreyCamera camera;
  bool full = true;
  camera.fail = [&] {
    if (std::exchange(full, false))
      throw DeviceFault("card-full", "the card is full", "empty it", true);
  };
  Script talk(DoneWhenAsked);
  EXPECT_TRUE(Run(camera, talk));
  EXPECT_EQ(talk.Count("ask", "ask", "camera"), 1);
}

TEST_F(SessionTest, WaitsForSpaceOnAFullDisk) {
  GreyCamera camera;
  bool full = true;
  camera.fail = [&] {
    if (std::exchange(full, false)) throw DiskError("no space left on the disk");
  };
  Script talk(DoneWhenAsked);
  EXPECT_TRUE(Run(camera, talk));
  EXPECT_EQ(talk.Count("fault", "fault", "disk-full"), 1);
  EXPECT_EQ(talk.Count("ask", "ask", "disk"), 1);
}

TEST_F(SessionTest, AsksForTheFocusOfEachPhotographOfAStack) {
  options_.plan.focus_stack = 2;
  struct Patterned final : GreyCamera {
    Exposure Take(const fs::path& into, bool, Patience&) override {
      Image8 image(64, 48, 3);
      for (std::size_t i = 0; i < image.data.size(); ++i)
        image.data[i] = static_cast<std::uint8_t>(90 + 60 * ((i / 30) % 2) + i % 61);
      WriteImage(into / "A.jpg", image);
      return {{into / "A.jpg"}, std::nullopt};
    }
  } camera;
  Script talk(DoneWhenAsked);
  EXPECT_TRUE(Run(camera, talk));
  EXPECT_EQ(talk.Count("ask", "ask", "camera"), 6);
  EXPECT_TRUE(fs::exists(project_ / "photos/rest/stacks/r1_a240_f2.jpg"));
  EXPECT_TRUE(fs::exists(project_ / "photos/rest/r1_a240.jpg"));
}

TEST_F(SessionTest, CarriesTheWhiteBalanceToTheNextPoseAndForgetsItWhenTold) {
  options_.white = CarriedWhite{{1.1, 1, 0.9}, "card.jpg:1,2,3,4"};
  GreyCamera camera;
  Script first(DoneWhenAsked);
  Run(camera, first);
  options_.white.reset();
  options_.pose = "bent";
  Script second(DoneWhenAsked);
  Run(camera, second);
  EXPECT_EQ(SideFileJson("bent").at("white_balance").at("gains").at(2), 0.9);
  options_.forget_white = true;
  Script third(DoneWhenAsked);
  Run(camera, third);
  EXPECT_FALSE(SideFileJson("bent").contains("white_balance"));
}

TEST_F(SessionTest, TheNextPoseMayHaveFewAnglesOfTheFirstRing) {
  GreyCamera camera;
  bool asked = false;
  Script talk([&](const json& event) -> std::vector<Command> {
    if (event.at("event") == "pose-done") {
      if (std::exchange(asked, true)) return {Of(Command::Kind::kEnd)};
      Command next = Of(Command::Kind::kNextPose);
      next.pose = "wave";
      next.angles = 4;
      return {next};
    }
    return DoneWhenAsked(event);
  });
  options_.stays_when_complete = true;
  Run(camera, talk);
  EXPECT_EQ(SideFileJson("wave").at("plan").at("angles"), 4);
  EXPECT_EQ(SideFileJson("wave").at("plan").at("rings_deg").size(), 1U);
  EXPECT_TRUE(fs::exists(project_ / "photos/wave/r1_a270.jpg"));
  EXPECT_NE(ReadFile(project_ / "pipeline.yaml").find("wave: {photos: photos/wave, method: fit}"),
            std::string::npos);
}

TEST_F(SessionTest, FewAnglesOfALaterPoseAreOneRingAsHighAsTheLastOnes) {
  GreyCamera camera;
  options_.plan = {.rings_deg = {20, 50}, .angles = 3};
  Script first(DoneWhenAsked);
  Run(camera, first);
  EXPECT_EQ(SideFileJson().at("plan").at("rings_deg"), json::array({20.0, 50.0}));
  options_.plan = {.angles = 4};
  options_.pose = "wave";
  for (int i = 0; i < 2; ++i) {
    Script again(DoneWhenAsked);
    EXPECT_TRUE(Run(camera, again));
    EXPECT_EQ(SideFileJson("wave").at("plan").at("rings_deg"), json::array({20.0}));
  }
  EXPECT_EQ(camera.releases, 8 + 5);
  options_.pose = "bow";
  options_.rings_given = true;
  Script given(DoneWhenAsked);
  Run(camera, given);
  EXPECT_EQ(SideFileJson("bow").at("plan").at("rings_deg"), json::array({12.0, 40.0}));
}

TEST_F(SessionTest, AnAngleCanBeLeftOutAndIsMissed) {
  GreyCamera camera;
  Script talk([](const json& event) -> std::vector<Command> {
    if (event.at("event") != "ask") return {};
    if (event.value("angle_deg", 0.0) == 240) return {Of(Command::Kind::kSkip)};
    return {Of(Command::Kind::kGoOn)};
  });
  EXPECT_TRUE(Run(camera, talk));
  EXPECT_EQ(SideFileJson().at("skipped"), json::array({"r1_a240"}));
  EXPECT_EQ(SideFileJson().at("rings").at(0).at("missing_deg"), json::array({240.0}));
}

TEST_F(SessionTest, ADeviceThatIsMissingAtTheStartIsAnErrorIfNobodyWaits) {
  options_.waits_for_devices = false;
  const auto camera = MakeFolderCamera(project_ / "nowhere");
  Script talk(DoneWhenAsked);
  EXPECT_THROW(Run(*camera, talk), ToolError);
}

TEST_F(SessionTest, WatchesAFolderAndLeavesWhatItHeldBefore) {
  const fs::path folder = project_ / "tether";
  fs::create_directories(folder);
  WritePicture(folder / "OLD.JPG", 10);
  const auto camera = MakeFolderCamera(folder, {.still_s = 0.05, .pair_s = 0.1});
  int given = 0;
  Script talk([&](const json& event) -> std::vector<Command> {
    // The person releases the camera when its angle is set; a text file beside does not count.
    const bool turned = event.at("event") == "ask" && event.at("ask") == "turn";
    const bool first = event.value("state", "") == "shooting" && given == 0;
    if (turned || first) {
      WriteFile(folder / "notes.txt", "x");
      ++given;
      WritePicture(folder / ("IMG_" + std::to_string(given) + ".JPG"), 100 + given);
    }
    if (event.at("event") == "ask" && !turned) return {Of(Command::Kind::kGoOn)};
    return {};
  });
  EXPECT_TRUE(Run(*camera, talk));
  EXPECT_EQ(given, 4);
  EXPECT_TRUE(fs::exists(folder / "IMG_1.JPG"));  // copied, not moved
  for (int i = 0; i < 3; ++i) {
    const std::string name = "r1_a" + std::string(i == 0 ? "000" : i == 1 ? "120" : "240");
    EXPECT_NEAR(SideFileJson().at("photographs").at(name).at("exposure").get<double>(), 101 + i, 1);
  }
}

}  // namespace keypose::capture::shoot::shooting_session_test
