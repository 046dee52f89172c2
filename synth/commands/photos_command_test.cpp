#include "synth/commands/photos_command.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <memory>

#include "core/io/meshes/mesh_io.h"
#include "core/io/pictures/image_io.h"
#include "core/io/project/landmarks_io.h"
#include "core/io/text/files.h"
#include "core/pictures/render.h"
#include "core/surfaces/ray_scene.h"
#include "core/testing/folder.h"
#include "core/testing/paths.h"
#include "core/values/errors.h"
#include "core/values/exif_focal.h"
#include "synth/commands/score_command.h"
#include "synth/photographs/mishaps.h"
#include "synth/photographs/testing/synth_files.h"
#include "synth/photographs/truth_files.h"
#include "synth/worlds/outer_surface.h"

namespace keypose::synth::photos_command_test {

namespace fs = std::filesystem;

TEST(SpreadOverRings, SixOfThirtySixAreSixtyDegreesApart) {
  PhotographerOptions rig;
  rig.views = 36;
  EXPECT_EQ(SpreadOverRings(rig, 6), (std::vector<int>{0, 6, 12, 21, 27, 33}));
}

TEST(SpreadOverRings, EveryNumberGivesDistinctViewsOfTheRig) {
  for (const std::vector<double>& rings :
       {std::vector<double>{20}, std::vector<double>{12, 40}, std::vector<double>{0, 20, 40}}) {
    PhotographerOptions rig;
    rig.elevations_deg = rings;
    rig.views = 17;
    for (int count = 1; count <= 17; ++count) {
      const std::vector<int> chosen = SpreadOverRings(rig, count);
      ASSERT_EQ(static_cast<int>(chosen.size()), count);
      EXPECT_GE(chosen.front(), 0);
      EXPECT_LT(chosen.back(), 17);
      for (std::size_t i = 1; i < chosen.size(); ++i) EXPECT_LT(chosen[i - 1], chosen[i]);
    }
  }
}

TEST(ReadFew, TakesPoseAndNumberAndRefusesOthers) {
  EXPECT_EQ(ReadFew({"wave=6", "bent=12"}),
            (std::map<std::string, int>{{"wave", 6}, {"bent", 12}}));
  for (const char* text : {"wave", "wave=", "=6", "wave=six", "wave=6x"})
    EXPECT_THROW(ReadFew({text}), UsageError) << text;
}

class FewPhotographs : public ::testing::Test {
 protected:
  static PhotosCommand Command(const fs::path& output) {
    PhotosCommand command;
    command.output = output;
    command.world.spacing_m = 0.008;
    command.photographer.views = 8;
    command.photographer.width = 120, command.photographer.height = 90;
    command.poses = {"rest", "wave", "limbs"};
    command.few = {{"wave", 4}, {"limbs", 2}};
    return command;
  }
  static void SetUpTestSuite() {
    own_ = std::make_unique<TestingFolder>();
    folder_ = own_->path();
    written_ = RunPhotos(Command(folder_), nullptr);
  }
  static void TearDownTestSuite() { own_.reset(); }
  static inline std::unique_ptr<TestingFolder> own_;
  static inline fs::path folder_;
  static inline int written_ = 0;
};

TEST_F(FewPhotographs, AreTakenWithTheCamerasOfTheRig) {
  EXPECT_EQ(written_, 8 + 4 + 2);
  const Truth rest = ReadTruth(folder_ / "truth/rest"), wave = ReadTruth(folder_ / "truth/wave");
  ASSERT_EQ(wave.cameras.views.size(), 4u);
  EXPECT_EQ(wave.cameras.views[3].name, "IMG_0004.jpg");
  const auto world = nlohmann::json::parse(ReadFile(folder_ / "truth/wave/world.json"));
  EXPECT_EQ(world.at("photographs").at("views"), 4);
  for (int i = 0; i < 4; ++i) {
    const std::string of_rig = world.at("rig_photographs").at(i);
    for (const View& view : rest.cameras.views)
      if (view.name == of_rig) {
        EXPECT_EQ(view.Center(), wave.cameras.views[i].Center()) << of_rig;
      }
  }
  EXPECT_EQ(wave.surface.faces, rest.surface.faces);
  EXPECT_GT((wave.surface.points - rest.surface.points).rowwise().norm().maxCoeff(), 0.02);
}

TEST_F(FewPhotographs, ShowThePoseAndNotTheRigs) {
  // The mask is that of the waving figure seen by that camera: the same as of a whole set.
  PhotosCommand all = Command(folder_ / "all");
  all.poses = {"rest"}, all.few = {};
  const World world = MakeWorld(all.world);
  const Photographer rig(world, world.PoseNamed("rest"), all.photographer);
  const Photographer wave(world, world.PoseNamed("wave"), all.photographer, &rig);
  const std::vector<int> chosen = SpreadOverRings(all.photographer, 4);
  EXPECT_EQ(ReadImage(folder_ / "truth/wave/masks/IMG_0002.jpg.png").data,
            wave.Take(chosen[1]).mask.data);
}

TEST_F(FewPhotographs, LimbAnglesAreInTheTruth) {
  const auto world = nlohmann::json::parse(ReadFile(folder_ / "truth/limbs/world.json"));
  EXPECT_EQ(world.at("pose_seed"), 1);
  ASSERT_EQ(world.at("limbs_deg").size(), 4u);
  for (const auto& [limb, angle] : world.at("limbs_deg").items()) {
    EXPECT_GE(angle.get<double>(), 30) << limb;
    EXPECT_LE(angle.get<double>(), 120) << limb;
  }
}

TEST_F(FewPhotographs, RigIsThatOfTheRestPoseWhenAllPosesAreFew) {
  PhotosCommand alone = Command(folder_ / "alone");
  alone.poses = {"wave"}, alone.few = {{"wave", 4}};
  EXPECT_EQ(RunPhotos(alone, nullptr), 4);
  EXPECT_EQ(ReadFile(folder_ / "alone/photos/wave/IMG_0003.jpg"),
            ReadFile(folder_ / "photos/wave/IMG_0003.jpg"));
}

TEST_F(FewPhotographs, BadCommandsAreNamed) {
  PhotosCommand command = Command(folder_ / "bad");
  command.few["bow"] = 3;
  EXPECT_THROW(RunPhotos(command, nullptr), UsageError);
  command = Command(folder_ / "bad");
  command.few["wave"] = 9;
  EXPECT_THROW(RunPhotos(command, nullptr), UsageError);
}

TEST_F(SynthFiles, PhotographsCarryTheCameraInTheirExif) {
  EXPECT_EQ(written_, 12);
  const ImageInfo info = ReadImageInfo(folder_ / "photos/bent/IMG_0006.jpg");
  EXPECT_EQ(info.width, 200);
  EXPECT_EQ(info.height, 150);
  // 60 by the longer side of 4:3; by the diagonal 57.7, which EXIF rounds
  EXPECT_DOUBLE_EQ(info.focal_35mm.value_or(0), 58);
  EXPECT_NEAR(FocalPx(200, 150, 58, *info.focal_mm, info.sensor_width_mm.value_or(0)),
              60.0 / 36 * 200, 1e-2);
  EXPECT_NEAR(info.focal_mm.value_or(0), 40, 0.01);
  EXPECT_NE(info.camera_model.find("Keypose"), std::string::npos);
  EXPECT_EQ(ReadImageInfo(folder_ / "background/rest.jpg").width, 200);
  EXPECT_EQ(ReadImage(folder_ / "truth/rest/masks/IMG_0001.jpg.png").channels, 1);
}

TEST(SynthGenus, TruthSaysWhatOneSeesThrough) {
  const TestingFolder folder;
  PhotosCommand command;
  command.output = folder.path();
  command.poses = {"rest", "hip"};
  command.world.spacing_m = 0.006;
  command.photographer.views = 2;
  command.photographer.width = 100, command.photographer.height = 75;
  RunPhotos(command, nullptr);
  const fs::path truth = command.output / "truth";
  const Truth rest = ReadTruth(truth / "rest");
  const std::string genus_at_rest = "\"genus\": " + std::to_string(Genus(rest.surface));
  EXPECT_NE(ReadFile(truth / "rest/world.json").find(genus_at_rest), std::string::npos);
  EXPECT_NE(ReadFile(truth / "hip/world.json").find("\"genus\": 1"), std::string::npos);
  EXPECT_FALSE(fs::exists(truth / "rest/outer.ply"));
  const Truth hip = ReadTruth(truth / "hip");
  EXPECT_EQ(Genus(hip.outer), 1);
  EXPECT_EQ(hip.surface.faces, rest.surface.faces);
}

TEST(SynthFlip, LyingPhotographsHaveTheirCamerasInTheStandingFrame) {
  const TestingFolder folder;
  PhotosCommand command;
  command.output = folder.path();
  command.poses = {"bent"};
  command.flip = true;
  command.world.spacing_m = 0.006;
  command.photographer.views = 4;
  command.photographer.width = 200, command.photographer.height = 150;
  EXPECT_EQ(RunPhotos(command, nullptr), 8);
  const Truth truth = ReadTruth(command.output / "truth/bent");
  const RayScene scene(truth.surface.points, truth.surface.faces);
  for (const View& view : truth.cameras.views) {
    const Image8 mask = ReadImage(command.output / "truth/bent/masks" / (view.name + ".png"), 1);
    const Raster raster = Rasterize(truth.surface, scene, view);
    int both = 0, either = 0;
    for (int y = 0; y < mask.height; ++y)
      for (int x = 0; x < mask.width; ++x) {
        const bool seen = *raster.face.at(x, y) >= 0, masked = *mask.at(x, y) > 127;
        both += seen && masked, either += seen || masked;
      }
    EXPECT_GT(both, 0.97 * either) << view.name;
  }
}

TEST_F(SynthFiles, PicksAreReadableLandmarksOfTheMesh) {
  const fs::path mesh_path = folder_ / "truth/rest/surface.ply",
                 output = folder_ / "rest_picks.json";
  RunPick({folder_ / "truth/rest", folder_ / "truth/rest/cameras", mesh_path, output, 0.03});
  const Mesh mesh = ReadMesh(mesh_path);
  const std::vector<Landmark> landmarks = ReadLandmarks(output, mesh);
  const Truth truth = ReadTruth(folder_ / "truth/rest");
  ASSERT_EQ(landmarks.size(), truth.landmarks.size());
  const Eigen::Vector3d expected = truth.surface.points.row(truth.landmarks[0].vertex);
  EXPECT_LT((PositionOf(landmarks[0], mesh) - expected).norm(), 1e-12);
}

TEST(SynthAgain, FewerPhotographsInOneFolderLeaveNoneOfTheWorldBefore) {
  const TestingFolder own;
  PhotosCommand command;
  command.output = own.path();
  command.world.spacing_m = 0.008;
  command.poses = {"rest"};
  command.photographer.views = 4;
  command.photographer.width = 64, command.photographer.height = 48;
  RunPhotos(command, nullptr);
  const fs::path photos = own.path() / "photos/rest", masks = own.path() / "truth/rest/masks";
  WriteFile(photos / "notes.txt", "mine");
  ASSERT_TRUE(fs::exists(photos / "IMG_0004.jpg") && fs::exists(masks / "IMG_0004.jpg.png"));
  command.photographer.views = 3;
  RunPhotos(command, nullptr);
  EXPECT_TRUE(fs::exists(photos / "IMG_0003.jpg"));
  EXPECT_FALSE(fs::exists(photos / "IMG_0004.jpg")) << "of the world before";
  EXPECT_FALSE(fs::exists(masks / "IMG_0004.jpg.png"));
  EXPECT_EQ(ReadFile(photos / "notes.txt"), "mine");
}

TEST(SynthAgain, PhotographsOfSomebodyElseAreNotWrittenOver) {
  const TestingFolder own;
  fs::create_directories(own.path() / "photos/rest");
  WriteFile(own.path() / "photos/rest/IMG_0001.jpg", "a real one");
  PhotosCommand command;
  command.output = own.path();
  command.world.spacing_m = 0.008;
  command.poses = {"rest"};
  EXPECT_THROW(RunPhotos(command, nullptr), UsageError);
  EXPECT_EQ(ReadFile(own.path() / "photos/rest/IMG_0001.jpg"), "a real one");
}

TEST(SynthProgram, ExitCodesNameTheFault) {
  const std::string program = BinFolder() + "/keypose-synth";
  const auto run = [&](const std::string& arguments) {
    return WEXITSTATUS(std::system((program + " " + arguments + " > /dev/null 2>&1").c_str()));
  };
  EXPECT_EQ(run("--help"), 0);
  EXPECT_EQ(run(""), 2);
  EXPECT_EQ(run("photos --output x --texture shiny"), 2);
  EXPECT_EQ(run("photos --output x --poses jump --spacing 0.01"), 2);
  EXPECT_EQ(run("photos --output x --character horse"), 2);
  EXPECT_EQ(run("pair /dev/null/x --bend 400"), 2);
  EXPECT_EQ(run("pair /dev/null/x --bend 60 --vertices 300"), 4);
  EXPECT_EQ(run("pick --truth /nonexistent --model m --mesh x --output y"), 3);
  EXPECT_EQ(run("damage --photos /nonexistent --output /dev/null/x --kind blur"), 4);
}

constexpr int kViews = 8;

PhotosCommand CommandTo(const fs::path& folder) {
  PhotosCommand command;
  command.output = folder;
  command.poses = {"rest"};
  command.world.spacing_m = 0.006;
  command.photographer.views = kViews;
  command.photographer.elevations_deg = {20};
  command.photographer.width = 200, command.photographer.height = 150;
  return command;
}

std::string Name(int i) { return "IMG_000" + std::to_string(i + 1) + ".jpg"; }

/// Photographs with mishaps, and the same photographs without.
class MishapsAtTheSet : public ::testing::Test, public TestingFolder {
 protected:
  static void SetUpTestSuite() {
    own_ = std::make_unique<TestingFolder>();
    clean_ = CommandTo(own_->path());
    RunPhotos(clean_, nullptr);
  }
  static void TearDownTestSuite() { own_.reset(); }

  void Spoil(const Mishaps& mishaps) {
    spoilt_ = CommandTo(folder_);
    spoilt_.photographer.mishaps = mishaps;
    EXPECT_EQ(RunPhotos(spoilt_, nullptr), kViews);
  }
  bool SameBytes(int i) const {
    const fs::path photograph = fs::path("photos/rest") / Name(i);
    return ReadFile(clean_.output / photograph) == ReadFile(spoilt_.output / photograph);
  }
  Image8 Mask(const PhotosCommand& of, int i) const {
    return ReadImage(of.output / "truth/rest/masks" / (Name(i) + ".png"), 1);
  }
  Image8 Photograph(const PhotosCommand& of, int i) const {
    return ReadImage(of.output / "photos/rest" / Name(i), 3);
  }
  nlohmann::json World() const {
    return nlohmann::json::parse(ReadFile(spoilt_.output / "truth/rest/world.json")).at("mishaps");
  }

  static inline std::unique_ptr<TestingFolder> own_;
  static inline PhotosCommand clean_, spoilt_;
};

int Count(const Image8& mask) {
  return static_cast<int>(std::count(mask.data.begin(), mask.data.end(), 255));
}

TEST_F(MishapsAtTheSet, StrayPhotographShowsAnotherFigureAndHasNoTrueCamera) {
  Mishaps mishaps;
  mishaps.strays = 1;
  Spoil(mishaps);
  const std::vector<int> strays = StrayViews(mishaps, kViews);
  ASSERT_EQ(strays.size(), 1u);
  for (int i = 0; i < kViews; ++i) EXPECT_EQ(SameBytes(i), i != strays[0]) << i;
  EXPECT_EQ(Count(Mask(spoilt_, strays[0])), 0);
  EXPECT_EQ(ReadTruth(spoilt_.output / "truth/rest").cameras.views.size(), kViews - 1u);
  EXPECT_EQ(World().at("stray").at("photographs"), nlohmann::json::array({Name(strays[0])}));
  EXPECT_EQ(World().at("stray").at("seed"), 2);
}

TEST_F(MishapsAtTheSet, HandCoversPartOfTheFigureAndLeavesTheRestAlone) {
  Mishaps mishaps;
  mishaps.hands = 2;
  Spoil(mishaps);
  const std::vector<int> hands = HandViews(mishaps, kViews);
  ASSERT_EQ(hands.size(), 2u);
  for (int i = 0; i < kViews; ++i) {
    const bool held = i == hands[0] || i == hands[1];
    EXPECT_EQ(SameBytes(i), !held);
    const Image8 before = Mask(clean_, i), after = Mask(spoilt_, i);
    const double left = static_cast<double>(Count(after)) / Count(before);
    if (!held) continue;
    EXPECT_GT(left, 0.5);
    EXPECT_LT(left, 0.97);
    for (std::size_t p = 0; p < before.data.size(); ++p) EXPECT_LE(after.data[p], before.data[p]);
  }
}

TEST_F(MishapsAtTheSet, MovedFigureIsSeenWhereItsTrueCamerasSayAndPhotographsBeforeAreTheSame) {
  Mishaps mishaps;
  ReadMove("0.5:8mm,15deg", &mishaps);
  Spoil(mishaps);
  const Truth truth = ReadTruth(spoilt_.output / "truth/rest");
  const RayScene scene(truth.surface.points, truth.surface.faces);
  for (int i = 0; i < kViews; ++i) {
    EXPECT_EQ(SameBytes(i), i < kViews / 2);
    const Image8 mask = Mask(spoilt_, i);
    const Raster raster = Rasterize(truth.surface, scene, truth.cameras.views[i]);
    int both = 0, either = 0;
    for (std::size_t p = 0; p < mask.data.size(); ++p) {
      const bool seen = raster.face.data[p] >= 0, masked = mask.data[p] > 127;
      both += seen && masked, either += seen || masked;
    }
    EXPECT_GT(both, 0.97 * either)
        << Name(i);  // "half of the pixel covered" and "centre covered" differ at the edge
  }
  EXPECT_NEAR(World().at("moved").at("deg").get<double>(), 15, 1e-9);
  EXPECT_EQ(World().at("moved").at("photographs").size(), 4u);
}

TEST_F(MishapsAtTheSet, FigureBumpedIntoAnotherPoseShowsThatPose) {
  Mishaps mishaps;
  ReadMove("0.75:bow", &mishaps);
  Spoil(mishaps);
  for (int i = 0; i < kViews; ++i) EXPECT_EQ(SameBytes(i), i < 6);
  EXPECT_NE(Mask(clean_, 7).data, Mask(spoilt_, 7).data);
  EXPECT_EQ(World().at("moved").at("pose"), "bow");
}

TEST_F(MishapsAtTheSet, FallenLampShadesAnewAndMovesNothing) {
  Mishaps mishaps;
  mishaps.lamp_falls_after = 0.5;
  Spoil(mishaps);
  for (int i = 0; i < kViews; ++i) {
    EXPECT_EQ(SameBytes(i), i < kViews / 2);
    EXPECT_EQ(Mask(clean_, i).data, Mask(spoilt_, i).data);
    if (i < kViews / 2) continue;
    // The lamp fell to the right: now the figure is lit on the right and no longer on the left.
    const Image8 before = Photograph(clean_, i), after = Photograph(spoilt_, i),
                 mask = Mask(clean_, i);
    double left[2] = {0, 0}, right[2] = {0, 0};
    for (int y = 0; y < mask.height; ++y)
      for (int x = 0; x < mask.width; ++x) {
        if (*mask.at(x, y) < 128) continue;
        double* sums = x < mask.width / 2 ? left : right;
        sums[0] += before.at(x, y)[1], sums[1] += after.at(x, y)[1];
      }
    EXPECT_GT(right[1] / left[1], 1.2 * right[0] / left[0]);
  }
}

}  // namespace keypose::synth::photos_command_test
