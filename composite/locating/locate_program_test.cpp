// The program keypose-locate on drawn pictures of a body.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "core/io/meshes/mesh_io.h"
#include "core/io/pictures/image_io.h"
#include "core/io/project/shot_io.h"
#include "core/io/testing/other_cut.h"
#include "core/io/text/files.h"
#include "core/numbers/rotations.h"
#include "core/pictures/render.h"
#include "core/pictures/srgb.h"
#include "core/surfaces/shapes.h"
#include "core/testing/folder.h"
#include "core/testing/paths.h"
#include "views/film/mp4.h"

namespace keypose::composite::locate_program_test {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

constexpr int kWidth = 480, kHeight = 360;

/// Four balls of different sizes, without any symmetry.
Mesh Body() {
  Mesh body;
  const double balls[4][4] = {{0, 0, 0.1, 0.07},
                              {0.09, 0.01, 0.13, 0.035},
                              {0.02, -0.08, 0.05, 0.03},
                              {-0.03, 0.03, 0.19, 0.028}};
  for (const auto& b : balls) {
    const Mesh ball = MakeIcosphere(3);
    const auto vertices = body.points.rows(), faces = body.faces.rows();
    body.points.conservativeResize(vertices + ball.points.rows(), 3);
    body.points.bottomRows(ball.points.rows()) =
        (b[3] * ball.points).rowwise() + Eigen::RowVector3d(b[0], b[1], b[2]);
    body.faces.conservativeResize(faces + ball.faces.rows(), 3);
    body.faces.bottomRows(ball.faces.rows()) = ball.faces.array() + static_cast<int>(vertices);
  }
  return body;
}

View Camera50() {
  View view;
  view.camera.width = kWidth, view.camera.height = kHeight;
  view.camera.fx = view.camera.fy = 50.0 / 36 * kWidth;
  view.camera.cx = kWidth / 2.0, view.camera.cy = kHeight / 2.0;
  view.camera_from_world = LookAt({0.3, -0.45, 0.25}, {0.01, 0, 0.11});
  return view;
}

class LocateProgram : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    own = std::make_unique<TestingFolder>();
    folder = own->path();
    fs::create_directories(folder / "film");
    fs::create_directories(folder / "mattes");
    const Mesh body = Body();
    WriteMesh(folder / "body.ply", body);
    const View view = Camera50();
    RenderOptions options;
    options.plain = true;
    const Image8 picture = Render(body, view, options);
    const Image8 cutout = RenderCutout(body, RayScene(body.points, body.faces), view, options);
    Image8 matte(kWidth, kHeight, 1);
    for (std::size_t i = 0; i < matte.data.size(); ++i) matte.data[i] = cutout.data[4 * i + 3];
    for (const char* name : {"0000.png", "0002.png"}) {
      WriteImage(folder / "film" / name, picture);
      WriteImage(folder / "mattes" / name, matte);
    }
  }
  static void TearDownTestSuite() { own.reset(); }

  /// @return the exit code; `%` in the words stands for the folder
  static int Run(std::string words) {
    for (std::size_t at; (at = words.find('%')) != std::string::npos;)
      words.replace(at, 1, folder.string());
    fs::remove(folder / "shot.json");
    const std::string f = folder.string();
    const std::string command = BinFolder() + "/keypose-locate " + words + " --shot " + f +
                                "/shot.json --report " + f + "/report.json > " + f + "/log 2>&1";
    return std::system(command.c_str()) >> 8;
  }
  static std::string Log() { return ReadFile(folder / "log"); }

  static inline std::unique_ptr<TestingFolder> own;
  static inline fs::path folder;
};

TEST_F(LocateProgram, WritesTheCameraOfAFilm) {
  ASSERT_EQ(Run("--mesh %/body.ply --poses rest --plate %/film --matte %/mattes --focal_35mm 50 "
                "--picture %/located.png --fps 12"),
            0)
      << Log();
  const FilmedShot shot = ReadShot(folder / "shot.json");
  ASSERT_EQ(shot.frames.size(), 2u);
  EXPECT_EQ(shot.frames[1].frame, 2);
  EXPECT_EQ(shot.frames[1].pose, "rest");
  EXPECT_EQ(shot.focal, "given");
  EXPECT_TRUE(shot.still);
  const View truth = Camera50();
  const Similarity3 found = CameraFromCharacter(shot.frames[0]);
  const Eigen::Vector3d top(-0.03, 0.03, 0.218);
  EXPECT_LT((shot.camera.Project(found * top) - truth.Project(top)).norm(), 1);
  EXPECT_GT(shot.frames[0].iou.value(), 0.98);
  EXPECT_LT(shot.frames[0].contour_px.value(), 0.5);
  EXPECT_EQ(ReadImage(folder / "located.png").height, kHeight);
  const auto report = nlohmann::json::parse(ReadFile(folder / "report.json"))["measurements"];
  EXPECT_EQ(report["frames_located"], 2);
  EXPECT_EQ(report["one_place"], true);
  EXPECT_LT(report["jitter_px"], 0.05);
}

TEST_F(LocateProgram, APoseWhosePolygonsAreCutAnotherWayServes) {
  const Mesh body = Body();
  WriteWithOtherCut(folder / "wave.obj", body);
  ASSERT_EQ((ReadMesh(folder / "wave.obj").faces - body.faces).rowwise().any().count(), 2);
  ASSERT_EQ(Run("--mesh %/body.ply --mesh %/wave.obj --poses rest,wave --shows 0=rest,2=wave "
                "--plate %/film --matte %/mattes --focal_35mm 50"),
            0)
      << Log();
  const FilmedShot shot = ReadShot(folder / "shot.json");
  ASSERT_EQ(shot.frames.size(), 2u);
  EXPECT_EQ(shot.frames[1].pose, "wave");
  EXPECT_GT(shot.frames[1].iou.value(), 0.98);
}

TEST_F(LocateProgram, PicturesOfSceneLightAreLookedAt) {
  fs::create_directories(folder / "light");
  const Image8 picture = ReadImage(folder / "film/0000.png", 3);
  ImageF light(kWidth, kHeight, 3);
  for (std::size_t i = 0; i < light.data.size(); ++i)
    light.data[i] = static_cast<float>(LinearFromSrgb(picture.data[i] / 255.0));
  WriteLinearImage(folder / "light/take_1001.exr", light);
  WriteLinearImage(folder / "light/take_1003.exr", light);
  ASSERT_EQ(Run("--mesh %/body.ply --plate %/light --matte %/mattes --focal_35mm 50"), 0) << Log();
  EXPECT_THAT(Log(), HasSubstr("linear light of Rec.709"));
  const FilmedShot shot = ReadShot(folder / "shot.json");
  ASSERT_EQ(shot.frames.size(), 2u);
  EXPECT_EQ(shot.frames[1].frame, 2);
  EXPECT_EQ(shot.frames[1].picture, "take_1003.exr");
  EXPECT_GT(shot.frames[0].iou.value(), 0.98);
}

TEST_F(LocateProgram, ColoursThatAreStatedOfPngAreRefused) {
  const std::string film = "--mesh %/body.ply --plate %/film --matte %/mattes ";
  EXPECT_EQ(Run(film + "--plate_colorspace ACEScg"), 2);
  EXPECT_THAT(Log(), HasSubstr("plate_colorspace and ocio_config are for OpenEXR and DPX plates"));
  WriteFile(folder / "show.ocio", "ocio_profile_version: 2");
  EXPECT_EQ(Run(film + "--ocio_config %/show.ocio"), 2);
  EXPECT_EQ(Run(film + "--background %/film --plate_colorspace ACEScg"), 2);
}

TEST_F(LocateProgram, AVideoIsAFilmOfItsOwnRate) {
  if (!CanWriteMp4()) GTEST_SKIP() << "libavcodec has no x264 here";
  const Image8 picture = ReadImage(folder / "film/0000.png", 3);
  Mp4Writer writer(folder / "take.mp4", kWidth, kHeight, 25);
  for (int i = 0; i < 3; ++i) writer.Add(picture);
  writer.Finish();
  const std::string command =
      "--mesh %/body.ply --plate %/take.mp4 --matte %/mattes --shows 0=0,2=0 --focal_35mm 50";
  ASSERT_EQ(Run(command), 0) << Log();
  const FilmedShot shot = ReadShot(folder / "shot.json");
  ASSERT_EQ(shot.frames.size(), 2u);
  EXPECT_EQ(shot.frames[1].frame, 2);
  EXPECT_NEAR(shot.fps, 25, 1e-9);
  EXPECT_GT(shot.frames[1].iou.value(), 0.98);
  ASSERT_EQ(Run(command + " --fps 12"), 0);
  EXPECT_EQ(ReadShot(folder / "shot.json").fps, 12) << "the rate that is given wins";
  EXPECT_THAT(Log(), HasSubstr("the video has 25 pictures a second"));
  const std::string whole = ReadFile(folder / "take.mp4");
  WriteFile(folder / "cut.mp4", whole.substr(0, whole.size() - 100));
  EXPECT_EQ(Run("--mesh %/body.ply --plate %/cut.mp4 --matte %/mattes"), 3);
  EXPECT_THAT(Log(), HasSubstr("cut.mp4 is cut off"));
}

TEST_F(LocateProgram, MattesMayBeAVideoOrAlpha) {
  const Image8 matte = ReadImage(folder / "mattes/0000.png", 1);
  Image8 cutout(kWidth, kHeight, 4, 90);  // its colours are no matte
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) cutout.at(x, y)[3] = *matte.at(x, y);
  WriteImage(folder / "cutout.png", cutout);
  const std::string one = "--mesh %/body.ply --plate %/film/0000.png --focal_35mm 50 --matte ";
  ASSERT_EQ(Run(one + "%/cutout.png"), 0) << Log();
  EXPECT_GT(ReadShot(folder / "shot.json").frames[0].iou.value(), 0.98);
  if (!CanWriteMp4()) GTEST_SKIP() << "libavcodec has no x264 here";
  Image8 grey(kWidth, kHeight, 3);
  for (std::size_t i = 0; i < grey.data.size(); ++i) grey.data[i] = matte.data[i / 3];
  Mp4Writer writer(folder / "mattes.mp4", kWidth, kHeight, 12);
  for (int i = 0; i < 3; ++i) writer.Add(i == 1 ? Image8(kWidth, kHeight, 3) : grey);
  writer.Finish();
  ASSERT_EQ(Run("--mesh %/body.ply --plate %/film --matte %/mattes.mp4 --focal_35mm 50"), 0)
      << Log();
  const FilmedShot shot = ReadShot(folder / "shot.json");
  ASSERT_EQ(shot.frames.size(), 2u);
  EXPECT_GT(shot.frames[1].iou.value(), 0.97) << "its frame 2, as the film has no frame 1";
  Mp4Writer brief(folder / "brief.mp4", kWidth, kHeight, 12);
  brief.Add(grey);
  brief.Finish();
  EXPECT_EQ(Run("--mesh %/body.ply --plate %/film --matte %/brief.mp4 --focal_35mm 50"), 3);
  EXPECT_THAT(Log(), HasSubstr("no matte for 0002.png"));
}

TEST_F(LocateProgram, MattesOfSomeFramesAreThoseOfTheirNumbers) {
  // The film begins at 1001; only the two frames that are shown have mattes.
  for (const char* name : {"numbered", "some_mattes"}) fs::create_directories(folder / name);
  const Image8 picture = ReadImage(folder / "film/0000.png", 3),
               matte = ReadImage(folder / "mattes/0000.png", 1);
  for (const char* name : {"a_1001.png", "a_1002.png", "a_1003.png", "a_1004.png", "a_1005.png"})
    WriteImage(folder / "numbered" / name, picture);
  WriteImage(folder / "some_mattes/m_1003.png", matte);
  WriteImage(folder / "some_mattes/m_1005.png", matte);
  ASSERT_EQ(Run("--mesh %/body.ply --plate %/numbered --matte %/some_mattes --shows 2=0,4=0 "
                "--focal_35mm 50"),
            0)
      << Log();
  EXPECT_GT(ReadShot(folder / "shot.json").frames[1].iou.value(), 0.98);
  EXPECT_EQ(Run("--mesh %/body.ply --plate %/numbered --matte %/some_mattes --shows 0=0,2=0"), 3);
  EXPECT_THAT(Log(), HasSubstr("there is no matte for a_1001.png"));
  EXPECT_EQ(Run("--mesh %/body.ply --plate %/numbered --matte %/some_mattes --shows 1003=0"), 3);
  EXPECT_THAT(Log(), HasSubstr("a_1001.png is frame 0 and a_1005.png frame 4"));
}

TEST_F(LocateProgram, AStillCameraTakesTheFirstOfSeveralPlates) {
  const Image8 picture = ReadImage(folder / "film/0000.png", 3),
               matte = ReadImage(folder / "mattes/0000.png", 1);
  Image8 plate = picture;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x)
      if (*matte.at(x, y) > 0) std::copy_n(picture.at(0, 0), 3, plate.at(x, y));
  fs::create_directories(folder / "two_plates");
  for (const char* name : {"empty_1.png", "empty_2.png"})
    WriteImage(folder / "two_plates" / name, plate);
  ASSERT_EQ(Run("--mesh %/body.ply --plate %/film --background %/two_plates --focal_35mm 50"), 0)
      << Log();
  EXPECT_GT(ReadShot(folder / "shot.json").frames[1].iou.value(), 0.95);
}

View MovedCamera(int frame) {
  View view = Camera50();
  view.camera_from_world = LookAt({0.3 + 0.03 * frame, -0.45, 0.25}, {0.01, 0, 0.11});
  return view;
}

TEST_F(LocateProgram, AMovingCameraIsFoundInFramesBetweenKeysToo) {
  for (const char* name : {"moving", "plates", "animation"}) fs::create_directories(folder / name);
  RenderOptions options;
  options.plain = true;
  for (int n = 0; n < 5; ++n) {
    Mesh body = Body();
    body.points.col(0) += 0.02 * n / 4 * body.points.col(2);
    WriteMesh(folder / "animation" / ("frame_000" + std::to_string(n) + ".ply"), body);
    if (n % 2) continue;
    const std::string name = "000" + std::to_string(n / 2) + ".png";
    WriteImage(folder / "moving" / name, Render(body, MovedCamera(n / 2), options));
    Image8 plate = Render(body, MovedCamera(n / 2), options);
    const Image8 cutout =
        RenderCutout(body, RayScene(body.points, body.faces), MovedCamera(n / 2), options);
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x)
        if (cutout.at(x, y)[3] > 0) std::copy_n(plate.at(0, 0), 3, plate.at(x, y));
    WriteImage(folder / "plates" / name, plate);
  }
  WriteFile(folder / "animation/distortion.json",
            R"({"schema": 2, "fps": 24, "key_frames": [0, 4], "frames": [{"t": 0}, {"t": 0.25},
                {"t": 0.5}, {"t": 0.75}, {"t": 1}]})");
  ASSERT_EQ(Run("--frames %/animation --poses rest,bent --shows 0=rest,2=bent --plate %/moving "
                "--background %/plates --focal_35mm 50 --camera moving --distortion false"),
            0)
      << Log();
  const FilmedShot shot = ReadShot(folder / "shot.json");
  EXPECT_FALSE(shot.still);
  ASSERT_EQ(shot.frames.size(), 3u) << "the one between is located by the animation";
  EXPECT_EQ(shot.frames[1].pose, "");
  EXPECT_EQ(shot.frames[2].pose, "bent");
  const Eigen::Vector3d middle(0, 0, 0.1);
  for (int i = 0; i < 3; ++i) {
    const Similarity3 found = CameraFromCharacter(shot.frames[i]);
    EXPECT_LT((shot.camera.Project(found * middle) - MovedCamera(i).Project(middle)).norm(), 1.5);
  }
  const auto report = nlohmann::json::parse(ReadFile(folder / "report.json"))["measurements"];
  EXPECT_TRUE(report.contains("camera_jitter_px"));
}

TEST_F(LocateProgram, AFocalLengthThatCannotBeSeenIsKeptAndSaidSo) {
  ASSERT_EQ(Run("--mesh %/body.ply --plate %/film/0000.png --matte %/mattes/0000.png"), 0) << Log();
  const FilmedShot shot = ReadShot(folder / "shot.json");
  EXPECT_TRUE(shot.focal == "kept" || shot.focal == "solved");
  EXPECT_GT(shot.focal_uncertainty, 0);
  if (shot.focal == "kept") {
    EXPECT_THAT(Log(), HasSubstr("--focal_35mm"));
  }
  EXPECT_GT(shot.frames[0].iou.value(), 0.98);
}

TEST_F(LocateProgram, ClicksPlaceItWithoutMatte) {
  const Mesh body = Body();
  const View truth = Camera50();
  nlohmann::json clicks{{"schema", 1}, {"clicks", nlohmann::json::array()}};
  for (const int v : {10, 700, 1400, 2100, 2500}) {
    const Eigen::Vector2d pixel = truth.Project(body.points.row(v).transpose());
    clicks["clicks"].push_back({{"pixel", {pixel.x(), pixel.y()}}, {"vertex", v}});
  }
  WriteFile(folder / "clicks.json", clicks.dump());
  ASSERT_EQ(Run("--mesh %/body.ply --plate %/film/0000.png --focal_35mm 50 --clicks %/clicks.json"),
            0)
      << Log();
  const FilmedShot shot = ReadShot(folder / "shot.json");
  EXPECT_EQ(shot.frames[0].method, "clicks");
  const Similarity3 found = CameraFromCharacter(shot.frames[0]);
  const Eigen::Vector3d top(-0.03, 0.03, 0.218);
  EXPECT_LT((shot.camera.Project(found * top) - truth.Project(top)).norm(), 2);
  ASSERT_EQ(Run("--mesh %/body.ply --plate %/film/0000.png --focal_35mm 50 --clicks %/clicks.json "
                "--quick true --picture %/located.png"),
            0)
      << Log();
  const FilmedShot quick = ReadShot(folder / "shot.json");
  EXPECT_FALSE(quick.frames[0].iou.has_value()) << "nothing to overlap with";
  EXPECT_LT((quick.camera.Project(CameraFromCharacter(quick.frames[0]) * top) - truth.Project(top))
                .norm(),
            2);
  ASSERT_EQ(Run("--mesh %/body.ply --plate %/film/0000.png --focal_35mm 50 --clicks %/clicks.json "
                "--quick true --matte %/mattes/0000.png"),
            0);
  EXPECT_GT(ReadShot(folder / "shot.json").frames[0].iou.value(), 0.97);
  EXPECT_EQ(Run("--mesh %/body.ply --plate %/film --clicks %/clicks.json --quick true"), 3);
  EXPECT_THAT(Log(), HasSubstr("0002.png has 0"));
  clicks["clicks"][2]["vertex"] = 99999;
  WriteFile(folder / "clicks.json", clicks.dump());
  EXPECT_EQ(Run("--mesh %/body.ply --plate %/film/0000.png --clicks %/clicks.json"), 3);
  EXPECT_THAT(Log(), HasSubstr("click 3 has vertex 99999"));
}

TEST_F(LocateProgram, MattesOfOtherProgramsAreTakenWithAWarning) {
  const Image8 matte = ReadImage(folder / "mattes/0000.png", 1);
  Image8 ones = matte, inverted = matte, cutout(kWidth, kHeight, 4, 60);
  for (std::size_t i = 0; i < matte.data.size(); ++i) {
    ones.data[i] = matte.data[i] > 127 ? 1 : 0;
    inverted.data[i] = static_cast<std::uint8_t>(255 - matte.data[i]);
    cutout.data[4 * i + 3] = matte.data[i];
  }
  struct Case {
    const char* name;
    Image8 matte;
    const char* said;
  };
  for (const Case& one :
       {Case{"ones", ones, "not black and white"}, Case{"inverted", inverted, "turned round"},
        Case{"half", Resized(matte, kWidth / 2, kHeight / 2), "was resized"},
        Case{"cutout", cutout, ""}}) {
    WriteImage(folder / (std::string(one.name) + ".png"), one.matte);
    ASSERT_EQ(Run("--mesh %/body.ply --plate %/film/0000.png --focal_35mm 50 --matte %/" +
                  std::string(one.name) + ".png"),
              0)
        << one.name << Log();
    EXPECT_THAT(Log(), HasSubstr(one.said)) << one.name;
    EXPECT_GT(ReadShot(folder / "shot.json").frames[0].iou.value(), 0.95) << one.name;
  }
  WriteImage(folder / "wide.png", Image8(kWidth, kHeight / 2, 1, 255));
  EXPECT_EQ(Run("--mesh %/body.ply --plate %/film/0000.png --matte %/wide.png"), 3);
  EXPECT_THAT(Log(), HasSubstr("the matte wide.png of 0000.png has 480 x 180 pixels"));
}

TEST_F(LocateProgram, AFrameWithoutTheCharacterIsRefused) {
  WriteImage(folder / "none.png", Image8(kWidth, kHeight, 1));
  EXPECT_EQ(Run("--mesh %/body.ply --plate %/film/0000.png --matte %/none.png"), 3);
  EXPECT_THAT(Log(), HasSubstr("no character found in 0000.png: its matte is empty"));
  EXPECT_EQ(Run("--mesh %/body.ply --plate %/film/0000.png --background %/film/0000.png"), 3);
  WriteImage(folder / "grey.png", Image8(kWidth, kHeight, 1, 90));
  EXPECT_EQ(Run("--mesh %/body.ply --plate %/film/0000.png --matte %/grey.png"), 3);
  EXPECT_THAT(Log(), HasSubstr("its matte is empty")) << "nowhere half covered";
  // A bar is no view of the body.
  Image8 bar(kWidth, kHeight, 1);
  for (int y = 100; y < 120; ++y)
    for (int x = 60; x < 420; ++x) *bar.at(x, y) = 255;
  WriteImage(folder / "bar.png", bar);
  EXPECT_EQ(Run("--mesh %/body.ply --plate %/film/0000.png --matte %/bar.png --focal_35mm 50"), 3);
  EXPECT_THAT(Log(), HasSubstr("IoU"));
  EXPECT_FALSE(fs::exists(folder / "shot.json"));
}

TEST_F(LocateProgram, WrongSizesPosesAndPortsAreNamed) {
  WriteImage(folder / "small.png", Image8(kWidth / 2, kHeight / 3, 1, 255));
  EXPECT_EQ(Run("--mesh %/body.ply --plate %/film/0000.png --matte %/small.png"), 3);
  EXPECT_THAT(Log(), HasSubstr("small.png of 0000.png has 240 x 120 pixels, but the picture 480 x "
                               "360"));
  fs::create_directories(folder / "mixed");
  fs::copy_file(folder / "film/0000.png", folder / "mixed/0000.png",
                fs::copy_options::overwrite_existing);
  WriteImage(folder / "mixed/0001.png", Image8(kWidth / 2, kHeight / 2, 3, 255));
  EXPECT_EQ(Run("--mesh %/body.ply --plate %/mixed --matte %/mattes"), 3);
  EXPECT_EQ(Run("--plate %/film/0000.png"), 2);
  EXPECT_THAT(Log(), HasSubstr("--frames"));
  EXPECT_EQ(Run("--mesh %/body.ply --plate %/film --matte %/mattes --poses rest --shows 0=wave"),
            2);
  EXPECT_THAT(Log(), HasSubstr("pose 'wave'"));
  EXPECT_EQ(Run("--mesh %/body.ply --mesh %/body.ply --plate %/film --matte %/mattes "
                "--poses rest,wave --shows 0=rest,2=wave,0=wave"),
            2);
  EXPECT_THAT(Log(), HasSubstr("frame 0 two poses"));
  EXPECT_EQ(Run("--mesh %/body.ply --plate %/film --poses 'rest' --shows '0=rest , 7=rest'"), 3);
  EXPECT_THAT(Log(), HasSubstr("frame 7")) << "spaces do no harm";
  EXPECT_EQ(Run("--mesh %/body.ply --plate %/film --matte %/mattes --shows 7=0"), 3);
  EXPECT_THAT(Log(), HasSubstr("frame 7"));
}

}  // namespace keypose::composite::locate_program_test
