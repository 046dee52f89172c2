// `keypose cameras`, with real processes and files. What the project's steps made is given.
#include <gmock/gmock.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "core/io/meshes/mesh_io.h"
#include "core/io/pictures/image_io.h"
#include "core/io/pictures/image_set.h"
#include "core/io/project/colmap_io.h"
#include "core/io/project/poses_io.h"
#include "core/testing/paths.h"
#include "pipeline/testing/installed_house.h"

namespace keypose::pipeline::cameras_test {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr char kSteps[] = R"(sources: {photos: {of: pose, default: "photos/{pose}", always: true}}
steps:
  capture: {stage: capture, for: pose, inputs: {photos: $photos}}
  sfm: {stage: sfm, for: pose, method: scan, inputs: {images: capture.images}, out: {model: "{pose}/model"}}
  masks: {stage: masks, for: pose, method: scan, inputs: {images: capture.images, model: sfm.model}, out: {masked: "{pose}/masked"}}
  fit: {stage: fit, for: pair, method: fit, inputs: {images: capture.images, rig: sfm.model@template}, out: {model: "{pose}/model"}}
)";

/// A camera at `eye` that looks at the origin, z up.
View LookFrom(const Eigen::Vector3d& eye, const Camera& camera, const std::string& name) {
  Eigen::Matrix3d axes;  // of the camera, in the world
  axes.col(2) = -eye.normalized();
  axes.col(0) = axes.col(2).cross(Eigen::Vector3d::UnitZ()).normalized();
  axes.col(1) = axes.col(2).cross(axes.col(0));
  const Rigid3 world_from_camera{Eigen::Quaterniond(axes).normalized(), eye};
  return {name, camera, world_from_camera.Inverse()};
}

/// Six views of two lenses: one is bent, with pixels that are not square; the other is a pinhole.
Scene TwoLenses() {
  Scene scene;
  const Camera bent{64, 48, 71.25, 70.5, 33.125, 22.75, -0.12, 0.03, 1e-3, -2e-3};
  const Camera pinhole{64, 48, 60, 60, 32, 24, 0, 0, 0, 0};
  for (int k = 0; k < 6; ++k) {
    const double angle = k * M_PI / 3 + 0.1;
    scene.views.push_back(LookFrom({3 * std::cos(angle), 3 * std::sin(angle), 1 + 0.1 * k},
                                   k < 4 ? bent : pinhole, "IMG_" + std::to_string(k) + ".jpg"));
  }
  for (int p = 0; p < 40; ++p) {
    SparsePoint point;
    point.position = {0.5 * std::sin(p), 0.5 * std::cos(2.0 * p), 0.02 * p - 0.3};
    point.color << static_cast<std::uint8_t>(6 * p), 20, 30;
    point.error_px = 0.25;
    point.views = p == 0 ? std::vector<int>{4, 5} : std::vector<int>{0, 1, 2, 3, 4, 5};
    scene.points.push_back(point);
  }
  return scene;
}

class Cameras : public RunTest {
 protected:
  void SetUp() override {
    RunTest::SetUp();
    fs::copy_file(BinFolder() + "/keypose-cameras", root_ / "bin/keypose-cameras");
    WriteFile(root_ / "share/keypose/pipeline.yaml", kSteps);
    WriteFile(root_ / "hero/pipeline.yaml",
              "poses: {rest: photos/rest, bent: {photos: photos/bent, method: fit}}\n"
              "template: rest\n");
    PutStage("capture", {"photos"}, "images");
    PutStage("sfm", {"images"}, "model");
    PutStage("masks", {"images", "model"}, "masked");
    PutStage("fit", {"images", "rig"}, "model");
    PutModel("sfm", TwoLenses());
    PutModel("fit", TwoLenses());
    PutImages(SixPhotographs());
  }

  /// A stage that gives what lies in made/STAGE.
  void PutStage(const std::string& stage, const std::vector<std::string>& in,
                const std::string& out) const {
    const auto port = [](const std::string& name) {
      return nlohmann::json{{"name", name},        {"kind", "folder"},  {"file", name},
                            {"repeatable", false}, {"optional", false}, {"help", ""}};
    };
    nlohmann::json about{{"schema", 1},
                         {"stage", stage},
                         {"version", "1"},
                         {"summary", "a test"},
                         {"inputs", nlohmann::json::array()},
                         {"outputs", {port(out)}},
                         {"options", nlohmann::json::array()},
                         {"tools", nlohmann::json::array()},
                         {"resources", {{"cores", 1}, {"memory_bytes", 1 << 20}}}};
    for (const std::string& name : in) about["inputs"].push_back(port(name));
    const fs::path program = root_ / "bin" / ("keypose-" + stage);
    WriteFile(program, "#!/bin/sh\n[ \"$1\" = --describe ] && { echo '" + about.dump() +
                           "'; exit; }\nwhile [ $# -gt 1 ]; do case $1 in\n --" + out +
                           ") cp -r '" + (root_ / "made" / stage).string() +
                           "' \"$2\";;\n --report) echo '{\"measurements\": {\"scale_source\": "
                           "\"board\"}}' > \"$2\";;\nesac; shift 2; done\n");
    fs::permissions(program, fs::perms::owner_all);
  }
  void PutModel(const std::string& stage, const Scene& scene) const {
    fs::create_directories(root_ / "made" / stage);
    WriteColmapModel(root_ / "made" / stage, scene);
  }
  static std::vector<CapturedImage> SixPhotographs() {
    std::vector<CapturedImage> images;
    for (const View& view : TwoLenses().views) {
      CapturedImage image;
      image.name = view.name;
      image.mask = "masks/" + view.name + ".png";
      image.width = 64;
      image.height = 48;
      images.push_back(image);
    }
    return images;
  }
  /// Of capture, and of masks, whose masks are others.
  void PutImages(const std::vector<CapturedImage>& images) const {
    for (const std::string stage : {"capture", "masks"}) {
      const fs::path folder = root_ / "made" / stage;
      fs::remove_all(folder);
      fs::create_directories(folder / "masks");
      for (const CapturedImage& image : images) {
        WriteImage(folder / image.name, Image8(64, 48, 3, 128));
        WriteImage(folder / image.mask, Image8(64, 48, 1, stage == "masks" ? 255 : 0));
      }
      WriteImageSet({.folder = folder,
                     .images = images,
                     .camera_model = {},
                     .board = {},
                     .board_print = {},
                     .floor = {}});
    }
  }
  /// Runs the project as SetUp made it, once for all tests.
  void MakeAll() const {
    static const TestingFolder kept;
    const fs::path state = root_ / "hero/.keypose", made = kept.path() / "made";
    if (fs::exists(made)) return fs::copy(made, state, fs::copy_options::recursive);
    ASSERT_EQ(Run().code, 0);
    fs::copy(state, made, fs::copy_options::recursive);
  }
  Ended Write(const std::string& format, const std::vector<std::string>& more = {}) const {
    std::vector<std::string> words{"cameras",  (root_ / "hero").string(), "--to", format,
                                   "--output", Folder(format).string()};
    words.insert(words.end(), more.begin(), more.end());
    return Keypose(words);
  }
  fs::path Folder(const std::string& format) const { return root_ / ("for_" + format); }

  /// Centres and projected points of what our own readers find in a file or folder.
  void ExpectSameCameras(const fs::path& written, double tolerance) const {
    const Scene truth = TwoLenses();
    const std::vector<View> read = ReadPoses(written);
    ASSERT_EQ(read.size(), truth.views.size()) << written;
    for (std::size_t v = 0; v < read.size(); ++v) {
      EXPECT_TRUE(read[v].name == truth.views[v].name ||
                  read[v].name + ".jpg" == truth.views[v].name);
      EXPECT_EQ(read[v].camera.width, 64);
      EXPECT_LT((read[v].Center() - truth.views[v].Center()).norm(), tolerance);
      for (const SparsePoint& point : truth.points)
        EXPECT_LT((read[v].Project(point.position) - truth.views[v].Project(point.position)).norm(),
                  tolerance)
            << written << " " << read[v].name;
    }
  }
  static std::vector<std::string> NamesIn(const fs::path& folder) {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder))
      names.push_back(entry.path().filename().string());
    std::sort(names.begin(), names.end());
    return names;
  }
  /// Runs a program of COLMAP. @return  its exit code
  int Colmap(const std::string& words) const {
    return std::system(
        ("colmap " + words + " > " + (root_ / "colmap.txt").string() + " 2>&1").c_str());
  }
};

TEST_F(Cameras, EveryFormatComesBackAsTheSameCameras) {
  MakeAll();
  for (const std::string format : {"colmap", "transforms", "metashape"}) {
    const Ended ended = Write(format);
    ASSERT_EQ(ended.code, 0) << ended.text;
    EXPECT_THAT(ended.text,
                HasSubstr("6 photographs with cameras and masks, 40 points; z is up, the "
                          "unit is a metre"));
    ExpectSameCameras(Folder(format), 1e-9);
    for (const View& view : TwoLenses().views)
      EXPECT_EQ(ReadFile(Folder(format) / "images" / view.name),
                ReadFile(root_ / "made/masks" / view.name));
  }
  const fs::path sparse = Folder("colmap") / "sparse/0";
  for (const char* file : {"cameras.bin", "images.bin", "points3D.bin"}) fs::remove(sparse / file);
  ExpectSameCameras(sparse, 1e-9);
  const Scene text = ReadColmapModel(sparse);
  ASSERT_EQ(text.points.size(), 40u);
  EXPECT_EQ(text.points[7].position, TwoLenses().points[7].position);
  EXPECT_EQ(text.points[0].views, (std::vector<int>{4, 5}));
}

TEST_F(Cameras, MasksHaveTheNamesThatProgramsLookFor) {
  MakeAll();
  for (const std::string format : {"colmap", "transforms", "metashape"})
    ASSERT_EQ(Write(format).code, 0);
  EXPECT_THAT(NamesIn(Folder("transforms")),
              ElementsAre("images", "masks", "points.ply", "transforms.json"));
  EXPECT_THAT(NamesIn(Folder("metashape")), ElementsAre("cameras.xml", "images", "masks"));
  EXPECT_THAT(NamesIn(Folder("colmap")), ElementsAre("images", "masks", "sparse"));
  EXPECT_THAT(
      NamesIn(Folder("metashape") / "masks"),
      ElementsAre("IMG_0.png", "IMG_1.png", "IMG_2.png", "IMG_3.png", "IMG_4.png", "IMG_5.png"));
  const fs::path agreed = root_ / "made/masks/masks/IMG_3.jpg.png";
  for (const char* mask : {"colmap/masks/IMG_3.jpg.png", "colmap/masks/IMG_3.png",
                           "transforms/masks/IMG_3.png", "metashape/masks/IMG_3.png"})
    EXPECT_EQ(ReadFile(root_ / ("for_" + std::string(mask))), ReadFile(agreed));
}

TEST_F(Cameras, TransformsAreThoseThatNerfstudioReads) {
  MakeAll();
  ASSERT_EQ(Write("transforms").code, 0);
  const auto root = nlohmann::json::parse(ReadFile(Folder("transforms") / "transforms.json"));
  EXPECT_EQ(root["camera_model"], "OPENCV");
  EXPECT_FALSE(root.contains("fl_x")) << "two lenses: each frame has its own";
  const auto& frame = root["frames"][1];
  EXPECT_EQ(frame["file_path"], "images/IMG_1.jpg");
  EXPECT_EQ(frame["mask_path"], "masks/IMG_1.png");
  EXPECT_EQ(frame["fl_y"], 70.5);
  EXPECT_EQ(frame["cx"], 33.125);
  EXPECT_EQ(frame["p2"], -2e-3);
  // Camera to world: x right, y up, z towards the back. The camera looks at the origin.
  const auto& m = frame["transform_matrix"];
  const Eigen::Vector3d center = TwoLenses().views[1].Center();
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(m[i][3].get<double>(), center[i], 1e-12);
    EXPECT_NEAR(m[i][2].get<double>(), center[i] / center.norm(), 1e-12);
  }
  EXPECT_GT(m[2][1].get<double>(), 0.9) << "z is up";
  EXPECT_NEAR(m[2][0].get<double>(), 0, 1e-12) << "the horizon is level";
  ASSERT_EQ(root["ply_file_path"], "points.ply");
  const PointCloud points = ReadPointCloud(Folder("transforms") / "points.ply");
  ASSERT_EQ(points.points.rows(), 40);
  EXPECT_LT((points.points.row(9).transpose() - TwoLenses().points[9].position).norm(), 1e-7);
}

TEST_F(Cameras, ColmapsProgramsTakeTheFolder) {
  if (Colmap("help") != 0) GTEST_SKIP() << "COLMAP is not installed";
  MakeAll();
  ASSERT_EQ(Write("colmap").code, 0);
  const fs::path sparse = Folder("colmap") / "sparse/0";
  const std::string folder = Folder("colmap").string();
  ASSERT_EQ(Colmap("model_analyzer --path " + sparse.string()), 0);
  EXPECT_THAT(ReadFile(root_ / "colmap.txt"),
              AllOf(HasSubstr("Registered images: 6"), HasSubstr("Points: 40"),
                    HasSubstr("Observations: 236")));
  fs::create_directories(root_ / "text");
  for (const bool binary : {true, false}) {
    ASSERT_EQ(Colmap("model_converter --output_type TXT --input_path " + sparse.string() +
                     " --output_path " + (root_ / "text").string()),
              0);
    ExpectSameCameras(root_ / "text", 1e-9);
    EXPECT_THAT(ReadFile(root_ / "text/cameras.txt"), HasSubstr("PINHOLE 64 48 60 60 32 24"));
    if (binary)
      for (const char* file : {"cameras.bin", "images.bin", "points3D.bin"})
        fs::remove(sparse / file);
  }
  ASSERT_EQ(Colmap("image_undistorter --image_path " + folder + "/images --input_path " + folder +
                   "/sparse/0 --output_path " + (root_ / "flat").string()),
            0)
      << ReadFile(root_ / "colmap.txt");
  const std::vector<View> flat = ReadPoses(root_ / "flat");
  ASSERT_EQ(flat.size(), 6u);
  EXPECT_FALSE(flat[0].camera.distorted());
  EXPECT_LT((flat[0].Center() - TwoLenses().views[0].Center()).norm(), 1e-9);
}

TEST_F(Cameras, OneLensStandsInTheHeadToo) {
  Scene scene = TwoLenses();
  for (View& view : scene.views) view.camera = scene.views[0].camera;
  scene.points.clear();
  PutModel("sfm", scene);
  ASSERT_EQ(Run().code, 0);
  ASSERT_EQ(Write("transforms").code, 0);
  const auto root = nlohmann::json::parse(ReadFile(Folder("transforms") / "transforms.json"));
  EXPECT_EQ(root["fl_x"], 71.25);
  EXPECT_EQ(root["frames"][0]["fl_x"], 71.25);
  EXPECT_FALSE(root.contains("ply_file_path"));
  EXPECT_FALSE(fs::exists(Folder("transforms") / "points.ply"));
}

TEST_F(Cameras, WhatIsNotPlacedOrTrustedIsLeftOutByName) {
  Scene scene = TwoLenses();
  scene.views.pop_back();
  for (SparsePoint& point : scene.points) std::erase(point.views, 5);
  PutModel("sfm", scene);
  auto images = SixPhotographs();
  images[1].trusted = false;
  PutImages(images);
  ASSERT_EQ(Run().code, 0);
  const Ended ended = Write("colmap");
  ASSERT_EQ(ended.code, 0) << ended.text;
  EXPECT_THAT(ended.text, AllOf(HasSubstr("4 photographs with cameras and masks, 39 points"),
                                HasSubstr("no camera: 1 of the photographs: IMG_5.jpg"),
                                HasSubstr("contradict the others (capture.json says why): 1 of "
                                          "the photographs: IMG_1.jpg")));
  const Scene read = ReadColmapModel(Folder("colmap"));
  EXPECT_EQ(read.views[1].name, "IMG_2.jpg");
  EXPECT_EQ(read.points[5].views, (std::vector<int>{0, 1, 2, 3}));
  EXPECT_EQ(NamesIn(Folder("colmap") / "images").size(), 4u);
}

TEST_F(Cameras, NamesThatAFormatCannotHoldOrTellApartKeepTheirEndings) {
  Scene scene = TwoLenses();
  auto images = SixPhotographs();
  const std::vector<std::string> names{"a b.jpg", "a.jpg", "a.png",
                                       "b.1.jpg", "b.jpg", "\u00fc&.jpg"};
  for (std::size_t i = 0; i < names.size(); ++i) {
    scene.views[i].name = images[i].name = names[i];
    images[i].mask = "masks/" + names[i] + ".png";
  }
  PutModel("sfm", scene);
  PutImages(images);
  ASSERT_EQ(Run().code, 0);
  for (const std::string format : {"colmap", "transforms", "metashape"}) {
    ASSERT_EQ(Write(format).code, 0);
    const std::vector<View> read = ReadPoses(Folder(format));
    ASSERT_EQ(read.size(), 6u);
    for (std::size_t i = 0; i < names.size(); ++i) EXPECT_EQ(read[i].name, names[i]);
    EXPECT_TRUE(fs::exists(Folder(format) / "masks/a.png.png"));
  }
  EXPECT_FALSE(fs::exists(Folder("colmap") / "sparse/0/images.txt"))
      << "COLMAP's text cannot hold a name with a space";
}

TEST_F(Cameras, APoseOfFewPhotographsHasThoseThatFitFound) {
  MakeAll();
  const Ended ended = Write("transforms", {"--pose", "bent"});
  ASSERT_EQ(ended.code, 0) << ended.text;
  EXPECT_THAT(ended.text, HasSubstr("the world and its unit are those of the template's cameras"));
  ExpectSameCameras(Folder("transforms"), 1e-9);
  EXPECT_EQ(ReadFile(Folder("transforms") / "masks/IMG_3.png"),
            ReadFile(root_ / "made/capture/masks/IMG_3.jpg.png"));
}

TEST_F(Cameras, FoldersOfOthersStay) {
  MakeAll();
  fs::create_directories(Folder("colmap"));
  WriteFile(Folder("colmap") / "mine.txt", "mine");
  const Ended refused = Write("colmap");
  EXPECT_EQ(refused.code, 4);
  EXPECT_THAT(refused.text, HasSubstr("is not empty; name another folder, or use --overwrite"));
  EXPECT_THAT(NamesIn(Folder("colmap")), ElementsAre("mine.txt"));
  ASSERT_EQ(Write("colmap", {"--overwrite"}).code, 0);
  EXPECT_THAT(NamesIn(Folder("colmap")), ElementsAre("images", "masks", "sparse"));
  ASSERT_EQ(Write("colmap", {"--force"}).code, 0);
  for (const char* place : {"hero", "hero/photos", "hero/photos/rest", "hero/photos/rest/new",
                            "hero/.keypose/cache", ""}) {
    const Ended ended = Keypose({"cameras", "-C", (root_ / "hero").string(), "--to", "colmap",
                                 "--overwrite", "-o", (root_ / place).string()});
    EXPECT_EQ(ended.code, 4) << place << ended.text;
    EXPECT_TRUE(fs::exists(root_ / "hero/photos/rest/IMG_1.jpg"));
    EXPECT_FALSE(fs::exists(root_ / "hero/photos/rest/new"));
  }
  for (const std::string& name : NamesIn(root_)) EXPECT_THAT(name, Not(HasSubstr("writing")));
}

TEST_F(Cameras, NothingIsLeftOfAFolderThatCannotBeWhole) {
  Scene scene = TwoLenses();
  auto images = SixPhotographs();
  scene.views[4].name = images[4].name = "a\x01.jpg";  // XML cannot hold it
  images[4].mask = "masks/a.png";
  PutModel("sfm", scene);
  PutImages(images);
  ASSERT_EQ(Run().code, 0);
  const Ended ended = Write("metashape");
  EXPECT_EQ(ended.code, 3) << ended.text;
  EXPECT_THAT(ended.text, HasSubstr("XML cannot hold this name"));
  EXPECT_FALSE(fs::exists(Folder("metashape")));
  for (const std::string& name : NamesIn(root_)) EXPECT_THAT(name, Not(HasSubstr("writing")));
}

TEST_F(Cameras, AProgramThatIsNotThereIsSaid) {
  fs::remove(root_ / "bin/keypose-cameras");
  const Ended ended = Write("colmap");
  EXPECT_EQ(ended.code, 5);
  EXPECT_THAT(ended.text, HasSubstr("keypose-cameras is not beside keypose"));
}

TEST_F(Cameras, WhatIsMissingIsSaidWithTheCommandThatHelps) {
  const std::string in = (root_ / "hero").string();
  const Ended early = Write("colmap");
  EXPECT_EQ(early.code, 3);
  EXPECT_THAT(early.text, HasSubstr("sfm/rest has not run yet; `keypose run -C " + in +
                                    " --until sfm/rest` makes it"));
  ASSERT_EQ(Run({"--until", "sfm"}).code, 0);
  EXPECT_THAT(Write("colmap").text, HasSubstr("masks/rest has not run yet"));
  ASSERT_EQ(Run().code, 0);
  const Ended other = Write("colmap", {"--pose", "best"});
  EXPECT_EQ(other.code, 2);
  EXPECT_THAT(other.text, HasSubstr("no pose 'best'; did you mean 'rest'?"));
  EXPECT_EQ(Keypose({"cameras", in}).code, 2);
  const Ended format = Keypose({"cameras", in, "--to", "blender"});
  EXPECT_EQ(format.code, 2);
  EXPECT_THAT(format.text, HasSubstr("colmap"));
  EXPECT_FALSE(fs::exists(Folder("colmap")));
}

TEST_F(Cameras, OlderCamerasAreWrittenAndThatIsSaid) {
  MakeAll();
  WriteFile(root_ / "hero/photos/rest/IMG_9.jpg", "another");
  const Ended ended = Write("transforms");
  EXPECT_EQ(ended.code, 0);
  EXPECT_THAT(ended.text, HasSubstr("these cameras are not of the present project: sfm/rest, "
                                    "masks/rest would run again"));
  ExpectSameCameras(Folder("transforms"), 1e-9);
}

TEST_F(Cameras, MasksOfOtherCamerasAreRefused) {
  MakeAll();
  Scene scene = TwoLenses();
  scene.views[0].camera.fx += 1;
  PutModel("sfm", scene);
  auto images = SixPhotographs();
  images[0].sharpness = 7;
  PutImages(images);
  WriteFile(root_ / "hero/photos/rest/IMG_9.jpg", "another");
  ASSERT_EQ(Run({"--until", "sfm/rest"}).code, 0);
  const Ended ended = Write("colmap");
  EXPECT_EQ(ended.code, 3);
  EXPECT_THAT(ended.text, HasSubstr("masks/rest was last made with other cameras than sfm/rest has "
                                    "now; `keypose run --until masks/rest`"));
  ASSERT_EQ(Run().code, 0);
  EXPECT_EQ(Write("colmap").code, 0);
}

TEST_F(Cameras, CamerasThatDoNotBelongToThePhotographsAreRefused) {
  Scene scene = TwoLenses();
  scene.views[2].camera.width = 63;
  PutModel("sfm", scene);
  ASSERT_EQ(Run().code, 0);
  const Ended size = Write("colmap");
  EXPECT_EQ(size.code, 3);
  EXPECT_THAT(size.text, HasSubstr("the camera of IMG_2.jpg is for 63 x 48 pixels, but the "
                                   "photograph has 64 x 48"));
  EXPECT_FALSE(fs::exists(Folder("colmap")));
}

}  // namespace keypose::pipeline::cameras_test
