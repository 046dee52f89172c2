// The moving mesh of a performance's shot over the routes: none yet, the tracked body, the scan.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>

#include "core/io/files.h"
#include "core/io/mesh_io.h"
#include "core/testing_shapes.h"
#include "studio/project/snapshot.h"
#include "studio/server/routes.h"

namespace keypose::studio {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::HasSubstr;

constexpr int kFrames = 3;

/// A stage that copies the frames that the test has put beside it.
constexpr char kCopy[] = R"sh(#!/bin/sh
here=$(dirname "$(readlink -f "$0")")
name=$(basename "$0")
if [ "$1" = --describe ]; then
  cat "$here/$name.json"
  exit
fi
while [ $# -gt 1 ]; do
  case "$1" in
    --frames) cp -r "$here/$name.frames" "$2" ;;
    --motion|--picture) echo made > "$2" ;;
    --report) echo '{"schema": 1, "measurements": {}}' > "$2" ;;
  esac
  shift 2
done
)sh";

constexpr char kProject[] = R"(name: dance
kind: performance
shots: {walk: films/walk, turn: films/turn}
scan: scan.ply
marks: marks.json
steps:
  silhouettes: {enabled: false}
  track:
    program: tools/track
    inputs: {video: $video, calibration: null, actor: null}
  transfer:
    program: tools/transfer
    inputs: {template: track.frames, target: $scan, marks: $marks}
  export: {enabled: false}
  report: {enabled: false}
)";

class MotionRoutes : public testing::Test {
 protected:
  MotionRoutes()
      : folder_(fs::temp_directory_path() / ("keypose_motion_" + std::to_string(getpid()))) {
    fs::remove_all(folder_);
    for (const char* folder : {"films/walk", "films/turn", "tools"})
      fs::create_directories(folder_ / folder);
    WriteFile(folder_ / "films/walk/cam1.mp4", "film");
    WriteFile(folder_ / "films/turn/cam1.mp4", "another film");
    WriteMesh(folder_ / "scan.ply", scan);
    WriteFile(folder_ / "marks.json", "{}");
    AddTool("track", {"video", "calibration", "actor"}, body);
    AddTool("transfer", {"template", "target", "marks"}, scan);
    WriteFile(folder_ / "pipeline.yaml", kProject);
  }
  ~MotionRoutes() override { fs::remove_all(folder_); }

  /// Its frames rise by 1 each.
  void AddTool(const std::string& name, const std::vector<std::string>& inputs, Mesh mesh) {
    const fs::path program = folder_ / "tools" / name, frames = program.string() + ".frames";
    WriteFile(program, kCopy);
    fs::permissions(program, fs::perms::owner_all);
    fs::create_directories(frames);
    json ports = json::array(), sizes = json::array();
    for (const std::string& input : inputs)
      ports.push_back({{"name", input}, {"kind", "path"}, {"optional", true}});
    for (int i = 0; i < kFrames; ++i) {
      WriteMesh(frames / ("frame_000" + std::to_string(i) + ".ply"), mesh);
      mesh.points.col(2).array() += 1;
      sizes.push_back({{"area", 1 + i}, {"volume", 2 + i}});
    }
    WriteFile(frames / "distortion.json", json{{"fps", 30}, {"frames", sizes}}.dump());
    json outputs = {{{"name", "frames"}, {"kind", "folder"}}};
    if (name == "track") {
      for (const char* file : {"actor.json", "angles.csv"}) WriteFile(frames / file, "{}");
      outputs.push_back({{"name", "motion"}, {"kind", "file"}, {"file", "motion.bvh"}});
      outputs.push_back({{"name", "picture"}, {"kind", "file"}, {"file", "tracked.jpg"}});
    }
    const json description = {{"schema", 1},         {"stage", name},   {"version", "1"},
                              {"summary", "copies"}, {"inputs", ports}, {"options", json::array()},
                              {"outputs", outputs}};
    WriteFile(program.string() + ".json", description.dump());
  }
  void Run(const std::string& until) {
    const fs::path log = folder_.string() + ".log";
    const std::string command = std::string(KEYPOSE_BIN_DIR) + "/keypose run -C " +
                                folder_.string() + " --until " + until + " > " + log.string() +
                                " 2>&1";
    ASSERT_EQ(std::system(command.c_str()), 0) << ReadFile(log);
    fs::remove(log);
  }
  Answer Ask(const std::string& path, const std::string& shot) {
    return Routes(folder_).Handle({"GET", path, {{"shot", shot}}, ""});
  }
  json Frames(const std::string& shot) { return json::parse(Ask("/api/frames", shot).bytes); }
  json Shots() { return json::parse(Ask("/api/project", "").bytes).at("poses"); }

  const fs::path folder_;
  const Mesh body = MakeIcosphere(1), scan = MakeIcosphere(2);
};

TEST_F(MotionRoutes, BeforeItIsTrackedThereIsNoneAndWhatToRunIsSaid) {
  for (const char* path : {"/api/frames", "/api/frames/positions", "/api/frames/first"}) {
    const Answer answer = Ask(path, "walk");
    EXPECT_EQ(answer.status, 400);
    EXPECT_THAT(answer.bytes, HasSubstr("track of shot 'walk'"));
  }
  EXPECT_EQ(Shots().at(0).at("has_frames"), false);
}

TEST_F(MotionRoutes, IsTheTrackedBodysThenTheScansAndOfItsOwnShotAlone) {
  Run("track/walk");
  EXPECT_EQ(Frames("walk").at("vertices"), body.vertex_count());
  EXPECT_EQ(Ask("/api/frames", "turn").status, 400);
  EXPECT_EQ(Shots().at(0).at("has_frames"), true);
  EXPECT_EQ(Shots().at(1).at("has_frames"), false);
  Run("transfer/walk");
  const json frames = Frames("walk");
  EXPECT_EQ(frames.at("vertices"), scan.vertex_count());
  EXPECT_EQ(frames.at("count"), kFrames);
  EXPECT_EQ(frames.at("fps"), 30);
  EXPECT_EQ(frames.at("volume"), json({2, 3, 4}));
}

TEST_F(MotionRoutes, PositionsAreThoseOfEachFrame) {
  Run("transfer/walk");
  const std::string bytes = Ask("/api/frames/positions", "walk").bytes;
  const std::size_t frame = 3 * static_cast<std::size_t>(scan.vertex_count());
  std::vector<float> numbers(kFrames * frame);
  ASSERT_EQ(bytes.size(), sizeof(float) * numbers.size());
  std::memcpy(numbers.data(), bytes.data(), bytes.size());
  for (int i = 0; i < kFrames; ++i)
    EXPECT_NEAR(numbers[static_cast<std::size_t>(i) * frame + 2], scan.points(0, 2) + i, 1e-6);
  EXPECT_EQ(Ask("/api/frames/first", "walk").bytes.substr(0, 4), "KPM1");
}

}  // namespace
}  // namespace keypose::studio
