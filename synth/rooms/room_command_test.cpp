#include "synth/rooms/room_command.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/io/pictures/image_io.h"
#include "core/io/project/colmap_io.h"
#include "core/io/text/files.h"
#include "core/testing/folder.h"
#include "core/values/angles.h"
#include "core/values/errors.h"
#include "synth/photographs/truth_files.h"
#include "synth/rooms/testing/small_room.h"

namespace keypose::synth::room_command_test {

namespace fs = std::filesystem;
using Eigen::Vector3d;

TEST(RoomCommand, WritesPhotographsAndTheirTruthBesideThem) {
  const TestingFolder folder;
  RoomCommand command;
  command.output = folder.path();
  command.room = Small("both", 4, 10);
  command.room.lenses = 2, command.room.exif = "yes";
  RunRoom(command, nullptr);
  const fs::path truth = folder.path() / "truth/figure", photos = folder.path() / "photos/figure";
  const auto json = nlohmann::json::parse(ReadFile(truth / "room.json"));
  EXPECT_EQ(json.at("kind"), "both");
  ASSERT_EQ(json.at("photographs").size(), 10u);
  const auto &ring = json["photographs"][0], &close = json["photographs"][9];
  EXPECT_EQ(ring.at("part"), "ring");
  EXPECT_EQ(ring.at("tripod"), 0);
  EXPECT_TRUE(close.at("tripod").is_null());
  EXPECT_NE(ring.at("portrait"), close.at("portrait"));
  EXPECT_NEAR(ReadImageInfo(photos / "IMG_0010.jpg").focal_35mm.value_or(0) /
                  json["lenses"][1]["focal_35mm"].get<double>(),
              1, 0.02);
  // A pixel inside the figure; both models hold the same camera in two frames.
  const Image8 mask = ReadImage(truth / "masks/IMG_0010.jpg.png", 1);
  EXPECT_EQ(*mask.at(close["inside"][0], close["inside"][1]), 255);
  const Scene of_figure = ReadColmapModel(truth / "cameras"),
              of_room = ReadColmapModel(truth / "cameras_of_room");
  const double turn = close["turn_deg"].get<double>() * kDegree;
  const Vector3d turned = Eigen::AngleAxisd(turn, Vector3d::UnitZ()) * of_figure.views[9].Center();
  EXPECT_LT((turned - of_room.views[9].Center()).norm(), 1e-9);
  EXPECT_GT(ReadTruth(truth).cameras.points.size(), 100u);
}

TEST(RoomCommand, ALineLiesOnWhatTouchesTheFigure) {
  const TestingFolder folder;
  RoomCommand command;
  command.output = folder.path();
  command.room = Small("walk", 5, 6);
  command.room.second = "touching";
  RunRoom(command, nullptr);
  const fs::path truth = folder.path() / "truth/figure";
  const auto json = nlohmann::json::parse(ReadFile(truth / "room.json"));
  int lines = 0;
  for (const auto& photograph : json.at("photographs")) {
    const auto& beside = photograph.at("beside");
    if (beside[0] < 0) continue;
    ++lines;
    const Image8 parts =
        ReadImage(truth / "parts" / (photograph["name"].get<std::string>() + ".png"), 1);
    EXPECT_EQ(beside[1], beside[3]);
    for (int x = beside[0]; x <= beside[2]; ++x)
      ASSERT_EQ(*parts.at(x, beside[1].get<int>()), static_cast<int>(Part::kThing));
  }
  EXPECT_GE(lines, 4);
}

TEST(RoomCommand, WithoutExifNoneIsWritten) {
  const TestingFolder folder;
  RoomCommand command;
  command.output = folder.path();
  command.room = Small("mat", 4, 4);
  command.room.exif = "no";
  RunRoom(command, nullptr);
  const ImageInfo info = ReadImageInfo(folder.path() / "photos/figure/IMG_0001.jpg");
  EXPECT_FALSE(info.focal_35mm.has_value());
  EXPECT_FALSE(info.focal_mm.has_value());
}

TEST(RoomCommand, PhotographsOfSomebodyElseAreNotWrittenOver) {
  const TestingFolder folder;
  fs::create_directories(folder.path() / "photos/figure");
  WriteFile(folder.path() / "photos/figure/IMG_0001.jpg", "a real one");
  RoomCommand command;
  command.output = folder.path();
  command.room = Small("mat", 4, 4);
  EXPECT_THROW(RunRoom(command, nullptr), UsageError);
}

}  // namespace keypose::synth::room_command_test
