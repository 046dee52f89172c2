// The output of keypose-synth: photographs with EXIF, their truth, damaged copies, exit codes.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <memory>
#include <numeric>

#include "core/io/meshes/mesh_io.h"
#include "core/io/pictures/image_io.h"
#include "core/io/project/colmap_io.h"
#include "core/io/project/landmarks_io.h"
#include "core/io/text/files.h"
#include "core/pictures/render.h"
#include "core/testing/folder.h"
#include "core/testing/paths.h"
#include "core/values/errors.h"
#include "synth/commands/photos_command.h"
#include "synth/commands/score_command.h"
#include "synth/photographs/damaged_photographs.h"
#include "synth/photographs/truth_files.h"
#include "synth/worlds/outer_surface.h"

namespace keypose::synth::files_test {

namespace fs = std::filesystem;

// Six small photographs per pose of two poses, rendered once for all tests of this file.
class SynthFiles : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    own_ = std::make_unique<TestingFolder>();
    command_.output = folder_ = own_->path();
    command_.world.spacing_m = 0.006;
    command_.photographer.views = 6;
    command_.photographer.width = 200, command_.photographer.height = 150;
    command_.clean_plate = true;
    written_ = RunPhotos(command_, nullptr);
  }
  static void TearDownTestSuite() { own_.reset(); }
  fs::path Spoilt(DamageKind kind, const std::string& name) const {
    const fs::path to = folder_ / ("spoilt_" + std::to_string(static_cast<int>(kind)));
    DamagePhotos(folder_ / "photos/rest", to, kind, {name});
    return to / name;
  }
  static inline std::unique_ptr<TestingFolder> own_;
  static inline fs::path folder_;
  static inline PhotosCommand command_;
  static inline int written_ = 0;
};

TEST_F(SynthFiles, PhotographsCarryTheCameraInTheirExif) {
  EXPECT_EQ(written_, 12);
  const ImageInfo info = ReadImageInfo(folder_ / "photos/bent/IMG_0006.jpg");
  EXPECT_EQ(info.width, 200);
  EXPECT_EQ(info.height, 150);
  EXPECT_DOUBLE_EQ(info.focal_35mm.value_or(0), 60);
  EXPECT_NEAR(info.focal_mm.value_or(0), 40, 0.01);
  EXPECT_NE(info.camera_model.find("Keypose"), std::string::npos);
  EXPECT_EQ(ReadImageInfo(folder_ / "background/rest.jpg").width, 200);
  EXPECT_EQ(ReadImage(folder_ / "truth/rest/masks/IMG_0001.jpg.png").channels, 1);
}

TEST_F(SynthFiles, TruthComesBackAsItWasRendered) {
  const World world = MakeWorld(command_.world);
  const Truth truth = ReadTruth(folder_ / "truth/bent");
  const Photographer photographer(world, world.PoseNamed("bent"), command_.photographer);
  EXPECT_EQ(truth.surface.points, photographer.surface().points);
  EXPECT_EQ(truth.surface.faces, world.rest.faces);
  ASSERT_EQ(truth.cameras.views.size(), 6u);
  for (int i = 0; i < 6; ++i) {
    EXPECT_EQ(truth.cameras.views[i].name, photographer.ViewAt(i).name);
    EXPECT_LT((truth.cameras.views[i].Center() - photographer.ViewAt(i).Center()).norm(), 1e-12);
    EXPECT_DOUBLE_EQ(truth.cameras.views[i].camera.k1, photographer.ViewAt(i).camera.k1);
  }
  ASSERT_EQ(truth.landmarks.size(), world.landmarks.size());
  EXPECT_EQ(truth.landmarks[3].vertex, world.landmarks[3].vertex);
  EXPECT_THROW(ReadTruth(folder_ / "photos"), Error);
}

TEST_F(SynthFiles, TruthScoresZeroAgainstItself) {
  ScoreCommand command{folder_ / "truth/bent",
                       folder_ / "truth/bent/cameras",
                       folder_ / "truth/bent/surface.ply",
                       {},
                       {},
                       {},
                       {},
                       {},
                       {}};
  const std::string json = RunScore(command);
  EXPECT_NE(json.find("\"placed\": 6"), std::string::npos);
  EXPECT_NE(json.find("\"closed\": true"), std::string::npos);
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

TEST_F(SynthFiles, DamagedCopiesAreDamagedAsNamedAndOriginalsAreNot) {
  const std::string name = "IMG_0002.jpg";
  const std::string original_bytes = ReadFile(folder_ / "photos/rest" / name);
  const Image8 original = ReadImage(folder_ / "photos/rest" / name, 3);
  EXPECT_THROW(ReadImage(Spoilt(DamageKind::kTruncate, name)), InputError);
  EXPECT_THROW(ReadImage(Spoilt(DamageKind::kEmpty, name)), InputError);
  EXPECT_THROW(ReadImage(Spoilt(DamageKind::kNoImage, name)), InputError);
  EXPECT_FALSE(fs::exists(Spoilt(DamageKind::kDrop, name)));
  EXPECT_FALSE(ReadImageInfo(Spoilt(DamageKind::kStripExif, name)).focal_35mm.has_value());
  EXPECT_EQ(ReadImageInfo(Spoilt(DamageKind::kResize, name)).width, 160);
  const Image8 dark = ReadImage(Spoilt(DamageKind::kDark, name), 3);
  EXPECT_LT(std::accumulate(dark.data.begin(), dark.data.end(), 0.0) /
                static_cast<double>(dark.data.size()),
            12);
  const fs::path turned = Spoilt(DamageKind::kRotate, name);
  EXPECT_EQ(ReadImageInfo(turned).orientation, 6);
  const Image8 upright = ReadImage(turned, 3);
  ASSERT_EQ(upright.width, original.width);
  double difference = 0;
  for (std::size_t i = 0; i < original.data.size(); ++i)
    difference += std::abs(original.data[i] - upright.data[i]);
  EXPECT_LT(difference / static_cast<double>(original.data.size()),
            3);  // one more JPEG compression
  EXPECT_EQ(ReadFile(folder_ / "photos/rest" / name), original_bytes);
}

TEST_F(SynthFiles, BlurTakesTheEdgesAway) {
  const auto roughness = [](const Image8& image) {
    double sum = 0;
    for (int y = 0; y < image.height; ++y)
      for (int x = 1; x < image.width; ++x)
        sum += std::abs(image.at(x, y)[1] - image.at(x - 1, y)[1]);
    return sum;
  };
  const double sharp = roughness(ReadImage(folder_ / "photos/rest/IMG_0001.jpg", 3));
  EXPECT_LT(roughness(ReadImage(Spoilt(DamageKind::kBlur, "IMG_0001.jpg"), 3)), 0.5 * sharp);
}

TEST_F(SynthFiles, UnknownDamageAndUnknownPhotographThrow) {
  EXPECT_THROW(DamageKindNamed("melt"), UsageError);
  EXPECT_THROW(
      DamagePhotos(folder_ / "photos/rest", folder_ / "spoilt_x", DamageKind::kDrop, {"none.jpg"}),
      InputError);
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

}  // namespace keypose::synth::files_test
