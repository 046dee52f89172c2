// Typical user errors, with the real programs: each fault has its exit code and a message that says
// what is wrong, where, and what to do.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/mount.h>
#include <unistd.h>

#include <cmath>
#include <fstream>
#include <memory>

#include "core/io/meshes/mesh_io.h"
#include "core/io/pictures/image_io.h"
#include "core/io/project/landmarks_io.h"
#include "core/io/text/files.h"
#include "core/surfaces/shapes.h"
#include "core/testing/folder.h"
#include "tests/run_program.h"

namespace keypose::tests::bad_input_test {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr int kOk = 0, kUsage = 2, kInput = 3, kDisk = 4, kTool = 5, kLocked = 7,
              kInterrupted = 130;

void WriteText(const fs::path& path, const std::string& text) {
  fs::create_directories(path.parent_path());
  WriteFile(path, text);
}

void WriteScript(const fs::path& path, const std::string& text) {
  WriteText(path, text);
  fs::permissions(path, fs::perms::owner_all);
}

bool Empty(const fs::path& folder) { return !fs::exists(folder) || fs::is_empty(folder); }

class BadInput : public ::testing::Test {
 protected:
  // One set of good photographs for all tests; each test damages a copy.
  static void SetUpTestSuite() {
    world_ = std::make_unique<TestingFolder>();
    const RunResult made =
        RunProgram({"keypose-synth", "photos", "--output", world_->path(), "--poses", "rest",
                    "--views", "10", "--width", "320", "--height", "240", "--spacing", "0.004"},
                   world_->path());
    ASSERT_EQ(made.exit_code, kOk) << made.output;
  }
  static void TearDownTestSuite() { world_.reset(); }

  static fs::path Photos() { return world_->path() / "photos" / "rest"; }
  const fs::path& here() const { return folder_.path(); }

  RunResult Keypose(std::vector<std::string> arguments,
                    const std::vector<std::string>& environment = {}) const {
    arguments.insert(arguments.begin(), "keypose");
    return RunProgram(arguments, here(), environment);
  }

  /// Runs a command and expects the exit code, words in the message, a one-line message, and no
  /// output.
  void ExpectFault(const std::vector<std::string>& arguments, int exit_code,
                   const std::vector<std::string>& words, const std::string& output = "",
                   const std::vector<std::string>& environment = {}) const {
    const RunResult result = Keypose(arguments, environment);
    EXPECT_EQ(result.exit_code, exit_code) << result.output;
    for (const auto& word : words) EXPECT_THAT(result.output, HasSubstr(word));
    EXPECT_THAT(result.output, HasSubstr("error: "));
    EXPECT_THAT(result.output, Not(HasSubstr("this is a bug")));
    if (output.empty()) return;
    EXPECT_FALSE(fs::exists(here() / output)) << "a half-made output was left";
    for (const auto& entry : fs::directory_iterator(here()))
      EXPECT_THAT(entry.path().filename().string(), Not(HasSubstr(output)))
          << "a temporary file was left";
  }

  fs::path Damaged(const std::string& kind, const std::vector<std::string>& names = {}) const {
    std::vector<std::string> command{"keypose-synth", "damage",      "--photos", Photos(),
                                     "--output",      here() / kind, "--kind",   kind};
    if (!names.empty()) command.push_back("--names");
    command.insert(command.end(), names.begin(), names.end());
    const RunResult made = RunProgram(command, here());
    EXPECT_EQ(made.exit_code, kOk) << made.output;
    return here() / kind;
  }

  static std::string FirstPhoto() {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(Photos())) {
      if (entry.path().extension() == ".jpg") names.push_back(entry.path().filename());
    }
    return *std::min_element(names.begin(), names.end());
  }

  fs::path MeshFile(const std::string& name, const Mesh& mesh) const {
    WriteMesh(here() / name, mesh);
    return here() / name;
  }

  /// A project whose only step is a script. The photographs are not read.
  fs::path ScriptProject(const std::string& script, const std::string& more_yaml = "") const {
    const fs::path project = here() / "project";
    fs::create_directories(project / "photos");
    fs::copy(Photos(), project / "photos" / "rest");
    WriteScript(project / "tools" / "step.sh",
                "#!/bin/sh\nif [ \"$1\" = --describe ]; then\n"
                "echo '{\"schema\":1,\"stage\":\"step\",\"version\":\"1\",\"inputs\":[],"
                "\"outputs\":[{\"name\":\"text\",\"kind\":\"file\"}]}'\nexit 0\nfi\n" +
                    script + "\n");
    WriteText(
        project / "pipeline.yaml",
        "poses:\n  rest: photos/rest\nsteps:\n  step: {program: tools/step.sh, for: project}\n" +
            more_yaml);
    return project;
  }

  TestingFolder folder_;
  static std::unique_ptr<TestingFolder> world_;
};
std::unique_ptr<TestingFolder> BadInput::world_;

// --- photographs ---

TEST_F(BadInput, NoPhotographs) {
  WriteText(here() / "shots" / "notes.txt", "none yet");
  ExpectFault({"capture", "--photos", "shots", "--images", "images"}, kInput,
              {"shots", "no photographs", ".jpg"}, "images");
  ExpectFault({"capture", "--photos", "elsewhere", "--images", "images"}, kInput,
              {"elsewhere", "check the path"}, "images");
}

TEST_F(BadInput, SinglePhotographOfAnotherSizeIsNamed) {
  const fs::path photos = Damaged("resize", {FirstPhoto()});
  const RunResult result = Keypose({"capture", "--photos", photos, "--images", "images"});
  EXPECT_EQ(result.exit_code, kOk) << result.output;
  EXPECT_THAT(result.output,
              AllOf(HasSubstr(FirstPhoto()), HasSubstr("320 x 240"), HasSubstr("different sizes")));
}

TEST_F(BadInput, TruncatedJpeg) {
  const fs::path photos = Damaged("truncate", {FirstPhoto()});
  ExpectFault({"capture", "--photos", photos, "--images", "images"}, kInput,
              {FirstPhoto(), "truncated", "leave it out"}, "images");
}

TEST_F(BadInput, NoExifWorksAndSaysThatTheFocalLengthIsAGuess) {
  const fs::path photos = Damaged("strip-exif");
  const RunResult result = Keypose({"capture", "--photos", photos, "--images", "images"});
  EXPECT_EQ(result.exit_code, kOk) << result.output;
  EXPECT_THAT(result.output, AllOf(HasSubstr("focal length"), HasSubstr("EXIF")));
  const RunResult good = Keypose({"capture", "--photos", Photos(), "--images", "good"});
  EXPECT_EQ(good.exit_code, kOk) << good.output;
  EXPECT_THAT(good.output, Not(HasSubstr("no focal length")));
}

TEST_F(BadInput, BlurredSet) {
  const fs::path photos = Damaged("blur");
  ExpectFault({"capture", "--photos", photos, "--images", "images"}, kInput,
              {"of 10 photographs are blurred", FirstPhoto(), "tripod"}, "images");
}

TEST_F(BadInput, MasksAllBlack) {
  for (const auto& entry : fs::directory_iterator(Photos())) {
    if (entry.path().extension() != ".jpg") continue;
    fs::create_directories(here() / "masks");
    WriteImage(here() / "masks" / (entry.path().filename().string() + ".png"),
               Image8(320, 240, 1, 0));
  }
  ExpectFault({"capture", "--photos", Photos(), "--masks", "masks", "--images", "images"}, kInput,
              {FirstPhoto(), "black", "--background"}, "images");
}

TEST_F(BadInput, PhotographsThatDoNotJoin) {
  if (!HasProgram("colmap")) GTEST_SKIP() << "colmap is missing: run ./dev setup";
  // Each photograph shows different blobs: no two have anything in common.
  std::uint32_t state = 1;
  const auto random = [&] { return (state = state * 1664525u + 1013904223u) >> 8; };
  fs::create_directories(here() / "shots");
  fs::create_directories(here() / "masks");
  for (int i = 0; i < 8; ++i) {
    Image8 image(240, 180, 3, 128);
    for (int blob = 0; blob < 250; ++blob) {
      const int cx = static_cast<int>(random() % 240), cy = static_cast<int>(random() % 180),
                size = 2 + static_cast<int>(random() % 7);
      const auto grey = static_cast<std::uint8_t>(random());
      for (int y = std::max(0, cy - size); y < std::min(180, cy + size); ++y) {
        for (int x = std::max(0, cx - size); x < std::min(240, cx + size); ++x)
          std::fill_n(image.at(x, y), 3, grey);
      }
    }
    const std::string name = "shot_" + std::to_string(i) + ".png";
    WriteImage(here() / "shots" / name, image);
    WriteImage(here() / "masks" / (name + ".png"), Image8(240, 180, 1, 255));
  }
  const RunResult captured =
      Keypose({"capture", "--photos", "shots", "--masks", "masks", "--images", "images"});
  ASSERT_EQ(captured.exit_code, kOk) << captured.output;
  ExpectFault({"sfm", "--images", "images", "--model", "model"}, kInput,
              {"do not join", "of 8", "shot_0.png", "more photographs"}, "model");
}

// --- meshes ---

TEST_F(BadInput, NanVertices) {
  Mesh mesh = MakeIcosphere(2);
  mesh.points(7, 1) = NAN;
  const fs::path bad = MeshFile("bad.ply", mesh), good = MeshFile("good.ply", MakeIcosphere(2));
  ExpectFault({"cleanup", "--surface", bad, "--clean", "clean.ply"}, kInput, {"vertex 7"},
              "clean.ply");
  ExpectFault({"register", "--source", bad, "--target", good, "--registered", "out.ply"}, kInput,
              {"vertex 7"}, "out.ply");
  ExpectFault({"register", "--source", good, "--target", bad, "--registered", "out.ply"}, kInput,
              {"vertex 7"}, "out.ply");
  ExpectFault({"interpolate", "--keys", good, "--keys", bad, "--frames", "frames"}, kInput,
              {"vertex 7"}, "frames");
}

TEST_F(BadInput, SurfaceThatNoPhotographShows) {
  const fs::path truth = world_->path() / "truth" / "rest";
  const RunResult captured =
      Keypose({"capture", "--photos", Photos(), "--masks", truth / "masks", "--images", "images"});
  ASSERT_EQ(captured.exit_code, kOk) << captured.output;
  Mesh far = MakeIcosphere(2), broken = far;
  far.points.col(2).array() += 1e4;
  broken.points(7, 1) = NAN;
  const auto refine = [&](const fs::path& surface, const std::vector<std::string>& words) {
    ExpectFault({"refine", "--images", "images", "--model", truth / "cameras", "--surface", surface,
                 "--refined", "refined.ply"},
                kInput, words, "refined.ply");
  };
  refine(MeshFile("far.ply", far), {"made from other photographs or cameras"});
  refine(MeshFile("broken.ply", broken), {"vertex 7"});
}

TEST_F(BadInput, EmptyMesh) {
  WriteText(here() / "no_vertices.ply",
            "ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float y\nproperty "
            "float z\n"
            "element face 0\nproperty list uchar int vertex_indices\nend_header\n");
  WriteText(here() / "no_bytes.ply", "");
  WriteText(here() / "no_faces.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n");
  const fs::path good = MeshFile("good.ply", MakeIcosphere(2));
  for (const std::string name : {"no_vertices.ply", "no_bytes.ply", "no_faces.obj"}) {
    ExpectFault({"cleanup", "--surface", name, "--clean", "clean.ply"}, kInput, {name},
                "clean.ply");
    ExpectFault({"unwrap", "--clean", name, "--unwrapped", "uv.obj"}, kInput, {name}, "uv.obj");
    ExpectFault({"register", "--source", good, "--target", name, "--registered", "out.ply"}, kInput,
                {name}, "out.ply");
  }
  ExpectFault({"mesh", "--cloud", "no_vertices.ply", "--surface", "surface.ply"}, kInput,
              {"no_vertices.ply", "0 points"}, "surface.ply");
}

TEST_F(BadInput, LandmarksPickedOnAnotherMesh) {
  const Mesh mesh = MakeIcosphere(2), other = MakeBox(1, 2, 5);
  const fs::path source = MeshFile("source.ply", mesh), target = MeshFile("target.ply", mesh);
  Landmark landmark{"left-eye", other.face_count() - 1, {0.2, 0.3, 0.5}};
  WriteLandmarks(here() / "source.json", other, {landmark});
  landmark.face = 5;
  WriteLandmarks(here() / "target.json", mesh, {landmark});
  ExpectFault({"register", "--source", source, "--target", target, "--landmarks", "source.json",
               "--landmarks", "target.json", "--registered", "out.ply"},
              kInput, {"source.json", "could not follow: 'left-eye'", "pick them again"},
              "out.ply");
  WriteText(
      here() / "source.json",
      R"({"schema":1,"mesh":{"vertices":642,"faces":1280},"landmarks":[{"name":"left-eye","face":5,"barycentric":[1,0,0]}]})");
  ExpectFault({"register", "--source", source, "--target", target, "--landmarks", "source.json",
               "--landmarks", "target.json", "--registered", "out.ply"},
              kInput,
              {"source.json", "1280 faces", "320 faces", "pick them again", "landmarks bind"},
              "out.ply");
  WriteText(here() / "pairs.txt", "3 4\n162 5\n");
  ExpectFault({"register", "--source", source, "--target", target, "--landmarks", "pairs.txt",
               "--registered", "out.ply"},
              kInput, {"pairs.txt:2", "162", "another mesh"}, "out.ply");
}

// --- projects ---

TEST_F(BadInput, UnknownYamlKeyNamesLineAndNearestKey) {
  const fs::path project = ScriptProject("echo hello > \"$2\"", "tmeplate: rest\n");
  ExpectFault({"run", "-C", project}, kUsage, {"pipeline.yaml:5", "tmeplate", "template"});
  EXPECT_FALSE(fs::exists(project / "out"));
}

TEST_F(BadInput, UnknownOptionNamesLineAndNearestOption) {
  const fs::path project =
      ScriptProject("echo hello > \"$2\"", "options:\n  cleanup: {facse: 100}\n");
  ExpectFault({"run", "-C", project}, kUsage, {"pipeline.yaml:6", "facse", "faces"});
}

TEST_F(BadInput, CycleNamesItsSteps) {
  const fs::path project =
      ScriptProject("echo hello > \"$2\"",
                    "  a: {stage: cleanup, for: pose, inputs: {surface: b.clean}}\n"
                    "  b: {stage: cleanup, for: pose, inputs: {surface: a.clean}}\n");
  ExpectFault({"run", "-C", project}, kUsage, {"pipeline.yaml:", "cycle", "a/rest", "b/rest"});
}

TEST_F(BadInput, MissingPhotographFolderNamesLine) {
  const fs::path project = ScriptProject("echo hello > \"$2\"");
  fs::remove_all(project / "photos" / "rest");
  const RunResult result = Keypose({"run", "-C", project});
  EXPECT_TRUE(result.exit_code == kUsage || result.exit_code == kInput) << result.exit_code << "\n"
                                                                        << result.output;
  EXPECT_THAT(result.output, AllOf(HasSubstr("pipeline.yaml:2"), HasSubstr("photos/rest")));
}

TEST_F(BadInput, CtrlCStopsAllChildrenAndTheNextRunWorks) {
  const fs::path project =
      ScriptProject("echo begun > begun; if [ -e " + (here() / "slow").string() +
                    " ]; then sleep 321.5; fi; echo hello > \"$2\"");
  WriteText(here() / "slow", "");
  Program run({"keypose", "run", "-C", project, "--only", "step", "--progress", "jsonl"}, here());
  ASSERT_TRUE(run.WaitForOutput("\"start\"", 60)) << run.Wait(5).output;
  usleep(300000);
  run.SendSignal(SIGINT);
  const RunResult stopped = run.Wait(30);
  EXPECT_EQ(stopped.exit_code, kInterrupted) << stopped.output;
  EXPECT_NE(RunProgram({"pgrep", "-f", "sleep 321.5"}, here()).exit_code, 0) << "a child survived";
  EXPECT_TRUE(Empty(project / ".keypose" / "tmp"));
  fs::remove(here() / "slow");
  const RunResult again = Keypose({"run", "-C", project, "--only", "step"});
  EXPECT_EQ(again.exit_code, kOk) << again.output;
}

TEST_F(BadInput, CtrlCOnAStageLeavesNoOutput) {
  const fs::path surface = MeshFile("surface.ply", MakeIcosphere(7));
  Program cleanup({"keypose-cleanup", "--surface", surface, "--clean", "clean.ply"}, here());
  usleep(1500000);
  ASSERT_TRUE(cleanup.running()) << "the mesh is too small for this test: "
                                 << cleanup.Wait(1).output;
  cleanup.SendSignal(SIGINT);
  const RunResult stopped = cleanup.Wait(60);
  EXPECT_EQ(stopped.exit_code, kInterrupted) << stopped.output;
  for (const auto& entry : fs::directory_iterator(here()))
    EXPECT_EQ(entry.path().filename(), "surface.ply") << "litter";
}

TEST_F(BadInput, ColmapMissingNamesThePackage) {
  const RunResult captured = Keypose({"capture", "--photos", Photos(), "--images", "images"});
  ASSERT_EQ(captured.exit_code, kOk) << captured.output;
  fs::create_directories(here() / "empty");
  ExpectFault({"sfm", "--images", "images", "--model", "model"}, kTool, {"colmap", "install"},
              "model", {"PATH=" + (here() / "empty").string(), "KEYPOSE_COLMAP="});
}

TEST_F(BadInput, SecondRunOnOneProjectIsRefusedAndTheFirstIsUnharmed) {
  const fs::path go_on = here() / "go_on";
  const fs::path project = ScriptProject("for i in $(seq 600); do [ -e " + go_on.string() +
                                         " ] && break; sleep 0.1; done; echo hello > \"$2\"");
  Program first({"keypose", "run", "-C", project, "--only", "step", "--progress", "jsonl"}, here());
  ASSERT_TRUE(first.WaitForOutput("\"start\"", 60)) << first.Wait(5).output;
  ExpectFault({"run", "-C", project, "--only", "step"}, kLocked, {"in use", "wait"});
  WriteText(go_on, "");
  const RunResult result = first.Wait(60);
  EXPECT_EQ(result.exit_code, kOk) << result.output;
}

// --- full disk ---

class FullDisk : public BadInput {
 protected:
  void SetUp() override {
    fs::create_directories(disk_);
    if (mount("tmpfs", disk_.c_str(), "tmpfs", 0, "size=128k") == 0) mounted_ = true;
  }
  void TearDown() override {
    if (mounted_) umount2(disk_.c_str(), MNT_DETACH);
  }
  bool Grow() const { return mount("tmpfs", disk_.c_str(), "tmpfs", MS_REMOUNT, "size=64m") == 0; }

  fs::path disk_ = here() / "disk";
  bool mounted_ = false;
};

TEST_F(FullDisk, StageSaysSoAndLeavesNothing) {
  if (!mounted_)
    GTEST_SKIP()
        << "a small tmpfs cannot be mounted here: run as root, outside a restricted container";
  const fs::path surface = MeshFile("surface.ply", MakeIcosphere(6));
  const RunResult result =
      Keypose({"cleanup", "--surface", surface, "--clean", disk_ / "clean.ply"});
  EXPECT_EQ(result.exit_code, kDisk) << result.output;
  EXPECT_THAT(result.output,
              AllOf(HasSubstr(disk_.string()), HasSubstr("clean.ply"), HasSubstr("space")));
  EXPECT_TRUE(fs::is_empty(disk_)) << fs::directory_iterator(disk_)->path();
}

TEST_F(FullDisk, RunSaysSoAndGoesOnWhenThereIsSpace) {
  if (!mounted_)
    GTEST_SKIP()
        << "a small tmpfs cannot be mounted here: run as root, outside a restricted container";
  const fs::path made = ScriptProject(
      "head -c 1000000 /dev/zero > \"$2\" || { echo 'cannot write: no space left on device' >&2; "
      "exit 4; }");
  fs::remove_all(made / "photos" / "rest");
  WriteText(made / "photos" / "rest" / "placeholder.jpg", "the step does not look at photographs");
  fs::copy(made, disk_ / "project", fs::copy_options::recursive);
  const std::vector<std::string> run{"run", "-C", disk_ / "project", "--only", "step"};
  const RunResult full = Keypose(run);
  EXPECT_EQ(full.exit_code, kDisk) << full.output;
  EXPECT_THAT(full.output, HasSubstr("space"));
  EXPECT_TRUE(Empty(disk_ / "project" / ".keypose" / "cache"));
  ASSERT_TRUE(Grow());
  const RunResult again = Keypose(run);
  EXPECT_EQ(again.exit_code, kOk) << again.output;
}

TEST_F(BadInput, AStageByHandRemovesNothingThatItDidNotWrite) {
  WriteMesh(here() / "source.ply", MakeIcosphere(2));
  WriteMesh(here() / "truth.ply", MakeIcosphere(2));
  WriteText(here() / "notes.txt", "a week of work");
  const std::vector<std::string> interpolate = {"interpolate", "--keys",  "source.ply", "--keys",
                                                "truth.ply",   "--steps", "1",          "--frames"};
  for (const char* place : {".", "..", "./"}) {
    std::vector<std::string> arguments = interpolate;
    arguments.emplace_back(place);
    ExpectFault(arguments, kDisk, {"name a folder of its own"});
    arguments.emplace_back("--overwrite");
    ExpectFault(arguments, kDisk, {"name a folder of its own"});
  }
  for (const char* name : {"source.ply", "truth.ply", "notes.txt"})
    EXPECT_TRUE(fs::exists(here() / name)) << name;

  fs::copy(Photos(), here() / "shoot");
  const std::string original = ReadFile(here() / "shoot/IMG_0001.jpg");
  ExpectFault({"capture", "--photos", "shoot", "--images", "shoot"}, kDisk,
              {"--photos", "would be lost"});
  ExpectFault({"capture", "--photos", "shoot", "--images", "shoot", "--overwrite"}, kDisk,
              {"--photos", "would be lost"});
  EXPECT_EQ(ReadFile(here() / "shoot/IMG_0001.jpg"), original);

  ExpectFault({"cleanup", "--surface", "source.ply", "--clean", "shoot", "--overwrite"}, kDisk,
              {"is a folder, but a file goes there"});
  ExpectFault({"cleanup", "--surface", "source.ply", "--clean", "source.ply"}, kDisk,
              {"--surface", "would be lost"});
  EXPECT_TRUE(fs::exists(here() / "shoot/IMG_0001.jpg"));

  std::vector<std::string> arguments = interpolate;
  arguments.emplace_back("frames");
  EXPECT_EQ(Keypose(arguments).exit_code, kOk);
  EXPECT_EQ(Keypose(arguments).exit_code, kOk) << "its own folder of before may be replaced";
  WriteText(here() / "frames/mine.txt", "a week of work");
  ExpectFault(arguments, kDisk, {"mine.txt", "--overwrite"});
  EXPECT_TRUE(fs::exists(here() / "frames/mine.txt"));
}

}  // namespace keypose::tests::bad_input_test
