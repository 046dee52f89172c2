// The program keypose-fit on photographs of a clay character, against the exact correspondence.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "core/io/meshes/mesh_io.h"
#include "core/io/pictures/image_io.h"
#include "core/io/pictures/image_set.h"
#include "core/io/project/colmap_io.h"
#include "core/io/project/landmarks_io.h"
#include "core/io/text/files.h"
#include "core/numbers/kd_tree.h"
#include "core/surfaces/ray_scene.h"
#include "core/testing/folder.h"
#include "core/testing/paths.h"

namespace keypose::fit::fit_program_test {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

int Call(const std::string& program, const std::string& words, const fs::path& log) {
  const std::string command =
      BinFolder() + "/keypose-" + program + " " + words + " > " + log.string() + " 2>&1";
  return std::system(command.c_str()) >> 8;
}

/// The template of a clay character, made from its true surface and cameras, and six photographs of
/// it with moved limbs. Made once for all tests.
class FitProgram : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    own = std::make_unique<TestingFolder>();
    folder = own->path();
    const std::string f = folder.string();
    Make("synth", "photos --output " + f + "/world --poses rest,limbs --views 20 --few limbs=6 " +
                      "--width 640 --spacing 0.005 --seed 5 --pose-seed 5");
    Make("cleanup", "--surface " + f + "/world/truth/rest/surface.ply --faces 5000 --clean " + f +
                        "/clean.ply");
    Make("unwrap", "--clean " + f + "/clean.ply --unwrapped " + f + "/template.obj");
    Make("capture", "--photos " + f + "/world/photos/rest --masks " + f +
                        "/world/truth/rest/masks --images " + f + "/rest");
    Make("capture",
         "--photos " + f + "/world/photos/limbs --images " + f + "/limbs --min_images 2");
    Make("bake", "--mesh " + f + "/template.obj --images " + f + "/rest --model " + f +
                     "/world/truth/rest/cameras --texture_size 1024 --hold_out 0 --texture " + f +
                     "/template.png");
  }
  static void TearDownTestSuite() { own.reset(); }

  static void Make(const std::string& program, const std::string& words) {
    ASSERT_EQ(Call(program, words, folder / "log"), 0)
        << program << ": " << ReadFile(folder / "log");
  }
  static int Fit(const fs::path& images, const fs::path& rig, const std::string& more = "") {
    return FitUntextured(images, rig,
                         "--texture " + (folder / "template.png").string() + " " + more);
  }
  static int FitUntextured(const fs::path& images, const fs::path& rig, const std::string& more) {
    const std::string f = folder.string();
    return Call("fit",
                "--template " + f + "/template.obj --images " + images.string() + " --rig " +
                    rig.string() + " --fitted " + f + "/fitted.obj --model " + f +
                    "/model --picture " + f + "/fitted.png --overwrite --report " + f +
                    "/fit.json " + more,
                folder / "log");
  }
  static fs::path Rig() { return folder / "world/truth/rest/cameras"; }
  static std::string Log() { return ReadFile(folder / "log"); }
  static nlohmann::json Measured() {
    return nlohmann::json::parse(ReadFile(folder / "fit.json"))["measurements"];
  }
  /// Errors over the diagonal against the exact correspondence, after alignment by the cameras.
  static nlohmann::json Scored() {
    const std::string f = folder.string(), rest = f + "/world/truth/rest";
    Make("synth", "score --truth " + f + "/world/truth/limbs --model " + f + "/model --mesh " + f +
                      "/fitted.obj --registered " + f + "/fitted.obj --template-truth " + rest +
                      " --template-model " + rest + "/cameras --template-mesh " + f +
                      "/template.obj --json " + f + "/score.json");
    return nlohmann::json::parse(ReadFile(folder / "score.json"))["correspondence"];
  }

  static inline std::unique_ptr<TestingFolder> own;
  static inline fs::path folder;
};

TEST_F(FitProgram, SixPhotographsGiveThePoseWithTheTemplatesFaces) {
  ASSERT_EQ(Fit(folder / "limbs", Rig()), 0) << Log();
  const Mesh fitted = ReadMesh(folder / "fitted.obj"), rest = ReadMesh(folder / "template.obj");
  EXPECT_EQ(fitted.faces, rest.faces);
  EXPECT_EQ(fitted.uv_faces, rest.uv_faces);
  const nlohmann::json score = Scored(), measured = Measured();
  EXPECT_LT(score["mean"], 0.004);
  EXPECT_LT(score["p95"], 0.015);
  EXPECT_EQ(score["flipped"], 0);
  EXPECT_EQ(measured["images_placed"], 6);
  EXPECT_EQ(measured["rig"], true);
  EXPECT_GT(measured["iou_mean"], 0.97);
  EXPECT_EQ(measured["flipped"], 0) << "the report's verdict goes by it";
  EXPECT_GT(ReadImage(folder / "fitted.png").width, 400);
}

/// What a person would click: a place of the template, and where photographs show it.
struct Clicks {
  Landmark place;
  nlohmann::json pixels = nlohmann::json::array();
};

/// The true clicks of a landmark of `synth`, in the first photographs that show it.
Clicks TrueClicks(const fs::path& folder, const std::string& name, std::size_t most) {
  const fs::path limbs = folder / "world/truth/limbs";
  const Mesh surface = ReadMesh(limbs / "surface.ply"), mesh = ReadMesh(folder / "template.obj");
  int vertex = -1;
  const nlohmann::json listed = nlohmann::json::parse(ReadFile(limbs / "landmarks.json"));
  for (const nlohmann::json& landmark : listed["landmarks"])
    if (landmark["name"] == name) vertex = landmark["vertex"];
  const PointsX3 at_rest = ReadMesh(folder / "world/truth/rest/surface.ply").points;
  const int nearest = KdTree(mesh.points).Nearest(at_rest.row(vertex).transpose()).index;
  // The landmark itself may lie inside another part.
  vertex = KdTree(at_rest).Nearest(mesh.points.row(nearest).transpose()).index;
  Clicks clicks;
  clicks.place.name = name;
  for (int f = 0; f < mesh.face_count(); ++f)
    for (int k = 0; k < 3; ++k)
      if (mesh.faces(f, k) == nearest) {
        clicks.place.face = f;
        clicks.place.barycentric = Eigen::Vector3d::Unit(k);
      }
  const RayScene scene(surface.points, surface.faces);
  const Eigen::Vector3d x = surface.points.row(vertex);
  constexpr double kBefore = 0.995;  // of the way: the place does not hide itself
  for (const View& view : ReadColmapModel(limbs / "cameras").views) {
    if (clicks.pixels.size() == most) break;
    if (scene.Occluded(view.Center(), x - view.Center(), 0, kBefore)) continue;
    const Eigen::Vector2d pixel = view.Project(x);
    clicks.pixels.push_back(
        {{"name", name}, {"image", view.name}, {"pixel", {pixel.x(), pixel.y()}}});
  }
  return clicks;
}

/// The flag for picks in two files, as a project has them.
std::string LandmarksFlag(const fs::path& folder, const std::vector<Clicks>& marks) {
  std::vector<Landmark> places;
  nlohmann::json pose;
  for (const Clicks& clicks : marks) {
    places.push_back(clicks.place);
    for (const nlohmann::json& pixel : clicks.pixels) pose["pixels"].push_back(pixel);
  }
  WriteLandmarks(folder / "rest.json", ReadMesh(folder / "template.obj"), places);
  WriteFileAtomically(folder / "limbs.json", pose.dump());
  return " --landmarks " + (folder / "rest.json").string() + " --landmarks " +
         (folder / "limbs.json").string();
}

// Without a texture the left hand, which turned, is found wrong.
TEST_F(FitProgram, ThreePicksBringAHandToItsPlaceWithAnyNumberOfThreads) {
  ASSERT_EQ(FitUntextured(folder / "limbs", Rig(), "--max_size 320"), 0) << Log();
  EXPECT_GT(Scored()["max"], 0.06);
  const Clicks finger = TrueClicks(folder, "left_finger", 2),
               elbow = TrueClicks(folder, "left_elbow", 1);
  ASSERT_EQ(finger.pixels.size() + elbow.pixels.size(), 3u);
  const std::string picks = LandmarksFlag(folder, {finger, elbow});
  ASSERT_EQ(setenv("KEYPOSE_THREADS", "1", 1), 0);
  ASSERT_EQ(FitUntextured(folder / "limbs", Rig(), "--max_size 320" + picks), 0) << Log();
  const std::string one = ReadFile(folder / "fitted.obj");
  ASSERT_EQ(setenv("KEYPOSE_THREADS", "3", 1), 0);
  ASSERT_EQ(FitUntextured(folder / "limbs", Rig(), "--max_size 320" + picks), 0) << Log();
  unsetenv("KEYPOSE_THREADS");
  EXPECT_EQ(one, ReadFile(folder / "fitted.obj"));
  EXPECT_LT(Scored()["max"], 0.04);
  EXPECT_EQ(Measured()["landmarks"], 3);
  EXPECT_EQ(Measured()["landmarks_refused"], 0);
  const nlohmann::json measured = Measured();
  for (const nlohmann::json& pick : measured["landmarks_off"]) EXPECT_LT(pick["off_px"], 4);
}

TEST_F(FitProgram, APickThatContradictsTheOthersIsNamedAndLeftOut) {
  Clicks clicks = TrueClicks(folder, "right_toe", 3);
  ASSERT_EQ(clicks.pixels.size(), 3u);
  clicks.pixels[1]["pixel"] = {200, 200};
  ASSERT_EQ(Fit(folder / "limbs", Rig(), "--max_size 320" + LandmarksFlag(folder, {clicks})), 0)
      << Log();
  EXPECT_THAT(Log(), HasSubstr("landmark 'right_toe' in photograph " +
                               clicks.pixels[1]["image"].get<std::string>() + " contradicts"));
  EXPECT_EQ(Measured()["landmarks"], 2);
  EXPECT_EQ(Measured()["landmarks_refused"], 1);
}

TEST_F(FitProgram, PicksInAPhotographThatIsNotThereAreAnError) {
  Clicks clicks = TrueClicks(folder, "left_finger", 1);
  clicks.pixels[0]["image"] = "IMG_0099.jpg";
  EXPECT_EQ(Fit(folder / "limbs", Rig(), LandmarksFlag(folder, {clicks})), 3);
  EXPECT_THAT(Log(), HasSubstr("pick 'left_finger' is in photograph 'IMG_0099.jpg'"));
}

/// A rig whose cameras stand elsewhere, with the same lens.
fs::path OtherRig(const fs::path& rig, const fs::path& other) {
  Scene scene = ReadColmapModel(rig);
  scene.views.resize(1);
  scene.points.clear();  // they name views that are gone
  scene.views[0].camera_from_world.translation.z() *= 2.5;
  fs::create_directories(other);
  WriteColmapModel(other, scene);
  return other;
}

TEST_F(FitProgram, FindsCamerasThatAreNoneOfTheRigs) {
  ASSERT_EQ(Fit(folder / "limbs", OtherRig(Rig(), folder / "other_rig"), "--max_size 320"), 0)
      << Log();
  EXPECT_EQ(Measured()["rig"], false);
  EXPECT_EQ(Measured()["images_placed"], 6);
  EXPECT_GT(Measured()["iou_mean"], 0.95);
  EXPECT_THAT(Log(), HasSubstr("not taken from the template's camera places"));
}

TEST_F(FitProgram, PhotographsOfAnotherCharacterAreRefused) {
  const std::string f = folder.string();
  Make("synth", "photos --output " + f +
                    "/stranger --poses bent --views 3 --width 320 --spacing "
                    "0.01 --seed 9");
  Make("capture", "--photos " + f + "/stranger/photos/bent --masks " + f +
                      "/stranger/truth/bent/masks --images " + f + "/strangers --min_images 2");
  fs::remove(folder / "fitted.obj");
  EXPECT_EQ(Fit(folder / "strangers", Rig(), "--max_size 320"), 3);
  EXPECT_THAT(Log(), HasSubstr("check that they show the same character as the template"));
  EXPECT_FALSE(fs::exists(folder / "fitted.obj"));
}

TEST_F(FitProgram, PhotographsOfAnotherSizeAreNamed) {
  const std::string f = folder.string();
  Make("synth", "photos --output " + f +
                    "/square --poses limbs --few limbs=3 --views 20 --width "
                    "300 --height 300 --spacing 0.01 --seed 5 --pose-seed 5");
  Make("capture", "--photos " + f + "/square/photos/limbs --masks " + f +
                      "/square/truth/limbs/masks --images " + f + "/squares --min_images 2");
  EXPECT_EQ(Fit(folder / "squares", Rig()), 3);
  EXPECT_THAT(Log(), HasSubstr("300 x 300"));
  EXPECT_THAT(Log(), HasSubstr("photograph all poses with one camera"));
}

TEST_F(FitProgram, PhotographsOfAShapeOfWhichTheTemplateHasSeveralLensesAreRefused) {
  Scene rig = ReadColmapModel(Rig());
  for (std::size_t v = 0; v < rig.views.size(); ++v)
    rig.views[v].camera = rig.views[v].camera.Scaled(v % 2 == 0 ? 2 : 0.5);
  fs::create_directories(folder / "two_lenses");
  WriteColmapModel(folder / "two_lenses", rig);
  EXPECT_EQ(Fit(folder / "limbs", folder / "two_lenses"), 3);
  EXPECT_THAT(Log(), HasSubstr("the template's lenses of this shape are several"));
}

TEST_F(FitProgram, EmptyMasksAreAnError) {
  fs::copy(folder / "limbs", folder / "black", fs::copy_options::recursive);
  const ImageSet set = ReadImageSet(folder / "black");
  for (int i = 0; i < static_cast<int>(set.images.size()); ++i)
    WriteImage(set.MaskPath(i), Image8(set.images[i].width, set.images[i].height, 1));
  EXPECT_EQ(Fit(folder / "black", Rig()), 3);
  EXPECT_THAT(Log(), HasSubstr("mask"));
}

TEST_F(FitProgram, AGateOnTheOverlapFailsWithItsOwnCode) {
  EXPECT_EQ(Fit(folder / "limbs", Rig(), "--max_size 320 --min_iou 1"), 6);
  EXPECT_THAT(Log(), HasSubstr("--min_iou"));
}

TEST_F(FitProgram, WithoutATextureOutlinesAloneBendTheTemplate) {
  const std::string f = folder.string();
  // Neither texture nor texture coordinates.
  ASSERT_EQ(Call("fit",
                 "--template " + f + "/clean.ply --images " + f + "/limbs --rig " + Rig().string() +
                     " --fitted " + f + "/bare.obj --model " + f +
                     "/model --overwrite --max_size 320 --min_iou 0.85 --report " + f + "/fit.json",
                 folder / "log"),
            0)
      << Log();
  EXPECT_THAT(Log(), HasSubstr("without a texture only outlines and picks"));
  EXPECT_EQ(Measured()["textured"], false);
  EXPECT_EQ(Measured()["images_placed"], 6);
  EXPECT_EQ(Measured()["placed_by_outlines"], 6);
  const Mesh rest = ReadMesh(folder / "clean.ply"), bare = ReadMesh(folder / "bare.obj");
  EXPECT_EQ(bare.faces, rest.faces);
  // The cameras are those of the rig by which the pose was photographed.
  const Scene rig = ReadColmapModel(Rig()), model = ReadColmapModel(folder / "model"),
              truth = ReadColmapModel(folder / "world/truth/limbs/cameras");
  PointsX3 centres(static_cast<Eigen::Index>(rig.views.size()), 3);
  for (std::size_t i = 0; i < rig.views.size(); ++i)
    centres.row(static_cast<Eigen::Index>(i)) = rig.views[i].Center();
  const KdTree nearest(centres);
  for (std::size_t i = 0; i < model.views.size(); ++i)
    EXPECT_EQ(nearest.Nearest(model.views[i].Center()).index,
              nearest.Nearest(truth.views[i].Center()).index)
        << model.views[i].name;
}

TEST_F(FitProgram, ATemplateWithoutTextureCoordinatesIsAnError) {
  const std::string f = folder.string();
  EXPECT_EQ(Call("fit",
                 "--template " + f + "/clean.ply --texture " + f + "/template.png --images " + f +
                     "/limbs --rig " + Rig().string() + " --fitted " + f + "/none.obj",
                 folder / "log"),
            3);
  EXPECT_THAT(Log(), HasSubstr("unwrap"));
}

}  // namespace keypose::fit::fit_program_test
