// The moving mesh of a performance's shot over the routes: none yet, the tracked body, the scan;
// its colours: the scan's own, and those that were painted from the films.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>
#include <memory>

#include "core/io/meshes/mesh_io.h"
#include "core/io/pictures/image_io.h"
#include "core/io/text/files.h"
#include "core/surfaces/shapes.h"
#include "core/testing/folder.h"
#include "core/testing/paths.h"
#include "studio/project/snapshot.h"
#include "studio/routes/routes.h"

namespace keypose::studio::motion_routes_test {

namespace fs = std::filesystem;
using nlohmann::json;
using ::testing::HasSubstr;

constexpr int kFrames = 3;

/// A stage that copies what the test has put beside it.
constexpr char kCopy[] = R"sh(#!/bin/sh
here=$(dirname "$(readlink -f "$0")")
name=$(basename "$0")
if [ "$1" = --describe ]; then
  cat "$here/$name.json"
  exit
fi
while [ $# -gt 1 ]; do
  case "$1" in
    --frames) if [ -d "$here/$name.frames" ]; then cp -r "$here/$name.frames" "$2"; fi ;;
    --textures) cp -r "$here/$name.textures" "$2" ;;
    --unwrapped) cp "$here/$name.obj" "$2" ;;
    --motion|--picture|--film) echo made > "$2" ;;
    --reference) if [ ! -e "$2" ]; then echo made > "$2"; fi ;;
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

/// Added to the project: the films painted on what moves.
constexpr char kPainted[] = R"(  layout:
    enabled: true
    program: tools/layout
    inputs: {clean: transfer.frames}
  video3d:
    enabled: true
    program: tools/video3d
    inputs: {frames: transfer.frames, calibration: null, masks: null, clocks: null}
)";

json File(const char* port, const char* file) {
  return {{"name", port}, {"kind", "file"}, {"file", file}};
}
json Folder(const char* port) { return {{"name", port}, {"kind", "folder"}}; }

/// Seen from above, one vertex one place.
void GiveUvs(Mesh* mesh, double size) {
  mesh->uvs = (mesh->points.leftCols(2).array() * size / 4 + 0.5).matrix();
  mesh->uv_faces = mesh->faces;
}

class MotionRoutes : public ::testing::Test, public TestingFolder {
 protected:
  MotionRoutes() {
    for (const char* folder : {"films/walk", "films/turn", "tools"})
      fs::create_directories(folder_ / folder);
    WriteFile(folder_ / "films/walk/cam1.mp4", "film");
    WriteFile(folder_ / "films/turn/cam1.mp4", "another film");
    WriteMesh(folder_ / "scan.ply", scan);
    WriteFile(folder_ / "marks.json", "{}");
    AddTool("track", {"video", "masks", "calibration", "actor"},
            json::array({Folder("frames"), File("reference", "reference.ply"),
                         File("motion", "motion.bvh"), File("picture", "tracked.jpg")}));
    AddTool("transfer", {"template", "reference", "target", "marks", "pins"},
            json::array({Folder("frames")}));
    AddFrames("track", body);
    AddFrames("transfer", scan);
    for (const char* file : {"actor.json", "angles.csv"})
      WriteFile(folder_ / "tools/track.frames" / file, "{}");
    WriteFile(folder_ / "pipeline.yaml", kProject);
  }

  ~MotionRoutes() override { routes_.reset(); }

  void AddTool(const std::string& name, const std::vector<std::string>& inputs, const json& outputs,
               const json& options = json::array()) {
    const fs::path program = folder_ / "tools" / name;
    WriteFile(program, kCopy);
    fs::permissions(program, fs::perms::owner_all);
    json ports = json::array();
    for (const std::string& input : inputs)
      ports.push_back({{"name", input}, {"kind", "path"}, {"optional", true}});
    const json description = {{"schema", 1},         {"stage", name},   {"version", "1"},
                              {"summary", "copies"}, {"inputs", ports}, {"options", options},
                              {"outputs", outputs}};
    WriteFile(program.string() + ".json", description.dump());
  }
  /// They rise by 1 each.
  void AddFrames(const std::string& tool, Mesh mesh) {
    const fs::path frames = folder_ / "tools" / (tool + ".frames");
    fs::create_directories(frames);
    json sizes = json::array();
    for (int i = 0; i < kFrames; ++i) {
      WriteMesh(frames / ("frame_000" + std::to_string(i) + ".ply"), mesh);
      mesh.points.col(2).array() += 1;
      sizes.push_back({{"area", 1 + i}, {"volume", 2 + i}});
    }
    WriteFile(frames / "distortion.json", json{{"fps", 30}, {"frames", sizes}}.dump());
  }
  /// Tools that paint: the layout of `scan`, and grey textures of brightness 40, 80, ...
  void AddPainters(int textures) {
    const json keep = {{"name", "keep"}, {"type", "bool"}, {"default", "false"}, {"help", "keeps"}};
    AddTool("layout", {"clean"}, json::array({File("unwrapped", "unwrapped.obj")}),
            json::array({keep}));
    AddTool("video3d", {"frames", "video", "calibration", "masks", "clocks", "layout", "texture"},
            json::array(
                {Folder("textures"), File("film", "film.mp4"), File("picture", "video3d.jpg")}));
    Mesh laid_out = scan;
    GiveUvs(&laid_out, 1);
    WriteMesh(folder_ / "tools/layout.obj", laid_out);
    fs::create_directories(folder_ / "tools/video3d.textures");
    for (int i = 0; i < textures; ++i)
      WriteImage(folder_ / "tools/video3d.textures" / ("frame_000" + std::to_string(i) + ".png"),
                 Image8(64, 32, 3, static_cast<std::uint8_t>(40 * (i + 1))));
  }
  void Project(const std::string& top, const std::string& steps) {
    routes_.reset();
    WriteFile(folder_ / "pipeline.yaml", top + kProject + steps);
  }
  void Run(const std::string& until) {
    routes_.reset();
    const fs::path log = folder_.string() + ".log";
    const std::string command = BinFolder() + "/keypose run -C " + folder_.string() + " --until " +
                                until + " > " + log.string() + " 2>&1";
    ASSERT_EQ(std::system(command.c_str()), 0) << ReadFile(log);
    fs::remove(log);
  }
  /// Reads the project anew after a run or another pipeline.yaml.
  Answer Handle(const Question& question) {
    if (!routes_) routes_ = std::make_unique<Routes>(folder_);
    return routes_->Handle(question);
  }
  Answer Ask(const std::string& path, const std::string& shot) {
    return Handle({"GET", path, {{"shot", shot}}, ""});
  }
  Answer Texture(const std::map<std::string, std::string>& query) {
    return Handle({"GET", "/api/frames/texture", query, ""});
  }
  json Colours() { return Frames("walk").at("colours"); }
  json Frames(const std::string& shot) { return json::parse(Ask("/api/frames", shot).bytes); }
  json Shots() { return json::parse(Ask("/api/project", "").bytes).at("poses"); }

  const Mesh body = MakeIcosphere(1), scan = MakeIcosphere(2);

 private:
  std::unique_ptr<Routes> routes_;
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

TEST_F(MotionRoutes, FrameTenThousandComesAfterThoseOfFourDigits) {
  const fs::path frames = folder_ / "tools/track.frames";
  const char* const numbers[kFrames] = {"9998", "9999", "10000"};
  for (int i = 0; i < kFrames; ++i)
    fs::rename(frames / ("frame_000" + std::to_string(i) + ".ply"),
               frames / (std::string("frame_") + numbers[i] + ".ply"));
  Run("track/walk");
  const std::string bytes = Ask("/api/frames/positions", "walk").bytes;
  const std::size_t frame = 3 * static_cast<std::size_t>(body.vertex_count());
  std::vector<float> positions(kFrames * frame);
  ASSERT_EQ(bytes.size(), sizeof(float) * positions.size());
  std::memcpy(positions.data(), bytes.data(), bytes.size());
  for (int i = 0; i < kFrames; ++i)
    EXPECT_NEAR(positions[static_cast<std::size_t>(i) * frame + 2], body.points(0, 2) + i, 1e-6);
}

/// The third number of the bytes of a mesh: 1 where it has texture coordinates.
std::uint32_t FlagsOf(const std::string& mesh_bytes) {
  std::uint32_t flags = 0;
  std::memcpy(&flags, mesh_bytes.data() + 12, sizeof flags);
  return flags;
}

TEST_F(MotionRoutes, WithoutTheStepsThatPaintItSaysHowToSwitchThemOn) {
  Run("transfer/walk");
  const json colours = Colours();
  EXPECT_EQ(colours.at("own"), "");
  EXPECT_TRUE(colours.at("video").is_null());
  EXPECT_THAT(colours.at("video_problem").get<std::string>(), HasSubstr("init --video3d"));
  EXPECT_EQ(FlagsOf(Ask("/api/frames/first", "walk").bytes), 0u);
  EXPECT_EQ(Texture({{"shot", "walk"}, {"frame", "0"}}).status, 404);
}

TEST_F(MotionRoutes, EachFrameHasTheTextureThatWasPaintedForIt) {
  AddPainters(kFrames);
  Project("", kPainted);
  Run("transfer/walk");
  EXPECT_THAT(Colours().at("video_problem").get<std::string>(), HasSubstr("run the steps up to"));
  Run("video3d/walk");
  const json video = Colours().at("video");
  EXPECT_EQ(video.at("width"), 64);
  EXPECT_EQ(video.at("height"), 32);
  EXPECT_EQ(Colours().at("video_problem"), "");
  EXPECT_EQ(FlagsOf(Ask("/api/frames/first", "walk").bytes), 1u);
  for (int i = 0; i < kFrames; ++i) {
    const Answer whole = Texture({{"shot", "walk"}, {"frame", std::to_string(i)}});
    ASSERT_EQ(whole.status, 200) << whole.bytes;
    EXPECT_EQ(ReadImage(whole.file, 3).data[0], 40 * (i + 1));
    const Answer small = Texture({{"shot", "walk"}, {"frame", std::to_string(i)}, {"width", "16"}});
    const Image8 picture = ReadImage(small.file, 3);
    EXPECT_EQ(picture.width, 16);
    EXPECT_EQ(picture.height, 8);
    EXPECT_NEAR(picture.data[0], 40 * (i + 1), 2);  // a JPEG
  }
}

TEST_F(MotionRoutes, TexturesAreOfTheirShotAndAskedForByNumberOnly) {
  AddPainters(kFrames);
  Project("", kPainted);
  Run("video3d/walk");
  EXPECT_EQ(Texture({{"shot", "walk"}, {"frame", "3"}}).status, 404);
  EXPECT_EQ(Texture({{"shot", "turn"}, {"frame", "0"}}).status, 404);
  for (const char* shot : {"", "none", "../walk"})
    EXPECT_EQ(Texture({{"shot", shot}, {"frame", "0"}}).status, 400) << shot;
  EXPECT_EQ(Texture({{"frame", "0"}}).status, 400);
  for (const char* frame : {"-1", "1e3", "0x1", "../0", "99999999999999999999"})
    EXPECT_EQ(Texture({{"shot", "walk"}, {"frame", frame}}).status, 400) << frame;
  EXPECT_EQ(Texture({{"shot", "walk"}, {"frame", "0"}, {"width", "-1"}}).status, 400);
}

TEST_F(MotionRoutes, TexturesOfAnotherNumberOfFramesAreNotShown) {
  AddPainters(kFrames - 1);
  Project("", kPainted);
  Run("video3d/walk");
  EXPECT_TRUE(Colours().at("video").is_null());
  EXPECT_THAT(Colours().at("video_problem").get<std::string>(), HasSubstr("2 textures"));
}

TEST_F(MotionRoutes, TexturesOfAnEarlierLayoutAreNotShown) {
  AddPainters(kFrames);
  Project("", kPainted);
  Run("video3d/walk");
  EXPECT_FALSE(Colours().at("video").is_null());
  Mesh laid_out = scan;
  GiveUvs(&laid_out, 0.5);
  WriteMesh(folder_ / "tools/layout.obj", laid_out);
  // A program is asked for its version again when it has changed.
  const fs::path program = folder_ / "tools/layout";
  json changed = json::parse(ReadFile(program.string() + ".json"));
  changed["version"] = "2";
  WriteFile(program.string() + ".json", changed.dump());
  WriteFile(program, std::string(kCopy) + "# another version\n");
  Run("layout/walk");
  EXPECT_TRUE(Colours().at("video").is_null());
  EXPECT_THAT(Colours().at("video_problem").get<std::string>(), HasSubstr("earlier layout"));
}

TEST_F(MotionRoutes, TheScansOwnTextureLiesInItsOwnLayout) {
  Mesh laid_out = scan;
  GiveUvs(&laid_out, 1);
  AddFrames("transfer", laid_out);
  WriteImage(folder_ / "hero.png", Image8(8, 8, 3, 77));
  Project("texture: hero.png\n", "");
  Run("transfer/walk");
  EXPECT_EQ(Colours().at("own"), "texture");
  EXPECT_EQ(ReadImage(Texture({{"shot", "walk"}}).file, 3).data[0], 77);
  EXPECT_EQ(Texture({{"shot", "none"}}).status, 400);
  // Unwrapped anew for the video: the own texture lies elsewhere.
  AddPainters(kFrames);
  GiveUvs(&laid_out, 0.5);
  WriteMesh(folder_ / "tools/layout.obj", laid_out);
  Project("texture: hero.png\n", kPainted);
  Run("video3d/walk");
  EXPECT_EQ(Colours().at("own"), "");
  EXPECT_THAT(Colours().at("own_problem").get<std::string>(), HasSubstr("another layout"));
  EXPECT_FALSE(Colours().at("video").is_null());
}

TEST_F(MotionRoutes, ATextureOutsideOfTheProjectIsNotRead) {
  Mesh laid_out = scan;
  GiveUvs(&laid_out, 1);
  AddFrames("transfer", laid_out);
  const fs::path outside = folder_.string() + ".png";
  WriteImage(outside, Image8(8, 8, 3, 77));
  fs::create_symlink(outside, folder_ / "link.png");
  for (const std::string& name : {outside.string(), std::string("link.png")}) {
    Project("texture: " + name + "\n", "");
    Run("transfer/walk");
    EXPECT_EQ(Colours().at("own"), "") << name;
    EXPECT_THAT(Colours().at("own_problem").get<std::string>(), HasSubstr("outside"));
    EXPECT_EQ(Texture({{"shot", "walk"}}).status, 404) << name;
  }
  fs::remove(outside);
}

TEST_F(MotionRoutes, ColoursOfTheScansVerticesAreItsOwnWhereItHasNoTexture) {
  Mesh coloured = scan;
  coloured.colors = ColorsX3::Constant(scan.vertex_count(), 3, 120);
  AddFrames("transfer", coloured);
  Run("transfer/walk");
  EXPECT_EQ(Colours().at("own"), "vertices");
  EXPECT_EQ(FlagsOf(Ask("/api/frames/first", "walk").bytes), 2u);
}

}  // namespace keypose::studio::motion_routes_test
