// `keypose calibrate` as a user runs it, on rendered pictures of a board.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <numbers>
#include <random>
#include <regex>

#include "capture/board/testing/seen_board.h"
#include "core/io/pictures/image_io.h"
#include "core/io/project/colmap_io.h"
#include "core/io/project/known_points_io.h"
#include "core/io/project/rig_calibration.h"
#include "core/io/text/files.h"
#include "core/pictures/fit_view.h"
#include "core/testing/folder.h"
#include "core/values/errors.h"
#include "tests/run_program.h"
#include "views/decode/testing/test_film.h"

namespace keypose::tests::calibrate_program_test {

namespace fs = std::filesystem;

/// Eight photographs of a figure on the printed board, rendered once; room/truth has the cameras.
const fs::path& Room() {
  static const TestingFolder folder;
  static const RunResult made =
      RunProgram({"keypose-synth", "photos", "--output", "room", "--poses", "rest", "--views", "8",
                  "--width", "640", "--spacing", "0.008", "--charuco", "--elevations", "25,50"},
                 folder.path());
  static const fs::path room = folder.path() / "room";
  EXPECT_EQ(made.exit_code, 0) << made.output;
  return room;
}

constexpr auto kNotOwn = "the board is not the one that `keypose capture` prints";

TEST(CalibrateProgram, LensOfRenderedPicturesComesOutAndAPoorlyCoveredPictureIsSaid) {
  const TestingFolder folder;
  fs::create_directories(folder.path() / "shot");
  fs::copy(Room() / "photos/rest", folder.path() / "shot/cam1");
  const RunResult run = RunProgram(
      {"keypose-calibrate", "--video", "shot", "--calibration", "rig.yml", "--every", "1"},
      folder.path());
  ASSERT_EQ(run.exit_code, 0) << run.output;
  EXPECT_EQ(run.output.find(kNotOwn), std::string::npos) << "its own board is known unsaid";
  EXPECT_NE(run.output.find("8 boards"), std::string::npos) << run.output;
  EXPECT_NE(run.output.find("its lens is a guess elsewhere"), std::string::npos) << run.output;
  const Scene truth = ReadColmapModel(Room() / "truth/rest/cameras");
  const RigCalibration rig = ReadRigCalibration(folder.path() / "rig.yml");
  ASSERT_EQ(rig.views.size(), 1u);
  EXPECT_EQ(rig.metres_per_unit, 1);
  // corners are found to a tenth of a pixel, over a third of the picture
  EXPECT_NEAR(rig.views[0].camera.fx / truth.views[0].camera.fx, 1, 0.005);
}

/// What calibrate says of these pictures, whose board is said by this word.
std::string SaidOfBoard(const fs::path& pictures, const std::string& word) {
  const TestingFolder folder;
  const RunResult run = RunProgram({"keypose-calibrate", "--video", pictures.string(),
                                    "--calibration", "rig.yml", "--every", "1", "--board", word},
                                   folder.path());
  EXPECT_EQ(run.exit_code, 0) << run.output;
  return run.output;
}

TEST(CalibrateProgram, OnlyABoardThatIsNotKeyposesOwnMustBeMeasured) {
  const TestingFolder folder;
  const fs::path shot = folder.path() / "shot";
  fs::create_directories(shot / "cam1");
  for (const int i : {1, 2, 3, 5, 6, 7}) {  // as many as a lens needs, and one more
    const std::string name = fmt::format("IMG_{:04}.jpg", i);
    fs::copy(Room() / "photos/rest" / name, shot / "cam1" / name);
  }
  EXPECT_EQ(SaidOfBoard(shot, "11x8").find(kNotOwn), std::string::npos);
  EXPECT_NE(SaidOfBoard(shot, "11x9").find(kNotOwn), std::string::npos) << "as its last row hides";
  EXPECT_EQ(SaidOfBoard(shot, "11x9:22mm").find(kNotOwn), std::string::npos) << "it was measured";
}

TEST(CalibrateProgram, PicturesWithoutABoardAreAnError) {
  const TestingFolder folder;
  const RunResult made = RunProgram({"keypose-synth", "photos", "--output", "room", "--poses",
                                     "rest", "--views", "6", "--width", "300", "--spacing", "0.01"},
                                    folder.path());
  ASSERT_EQ(made.exit_code, 0) << made.output;
  fs::create_directories(folder.path() / "shot");
  fs::rename(folder.path() / "room/photos/rest", folder.path() / "shot/cam1");
  const RunResult run = RunProgram(
      {"keypose-calibrate", "--video", "shot", "--calibration", "rig.yml"}, folder.path());
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_NE(run.output.find("cam1 saw the board in only 0 frames"), std::string::npos)
      << run.output;
  EXPECT_NE(run.output.find("none showed markers or a checkerboard"), std::string::npos)
      << run.output;
}

/// Points of known place about the figure, clicked where the truth's first view sees them.
std::string ClickedPoints(const View& view, int wrong) {
  KnownPoints known;
  ClickedPicture clicked{"still", "", view.camera.width, view.camera.height, {}};
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector3d place(i & 1 ? 0.06 : -0.06, i & 2 ? 0.05 : -0.05, i & 4 ? 0.08 : 0);
    known.points.push_back({"corner " + std::to_string(i), place});
    Eigen::Vector2d pixel = view.Project(place);
    if (i == wrong) pixel += Eigen::Vector2d(40, -25);
    clicked.clicks.push_back({i, pixel});
  }
  known.cameras = {clicked};
  return KnownPointsText(known);
}

TEST(CalibrateProgram, BoardPicturesGiveTheLensAndClickedPointsThePlace) {
  const TestingFolder folder;
  fs::create_directories(folder.path() / "boards");
  fs::copy(Room() / "photos/rest", folder.path() / "boards/still");
  const View truth = ReadColmapModel(Room() / "truth/rest/cameras").views[0];
  WriteFile(folder.path() / "points.json", ClickedPoints(truth, 5));
  const RunResult run = RunProgram({"keypose-calibrate", "--lenses", "boards", "--points",
                                    "points.json", "--calibration", "rig.yml"},
                                   folder.path());
  ASSERT_EQ(run.exit_code, 0) << run.output;
  EXPECT_NE(run.output.find("the click of 'corner 5' is 4"), std::string::npos) << run.output;
  EXPECT_EQ(run.output.find("the click of 'corner 4'"), std::string::npos) << run.output;
  const View placed = ReadRigCalibration(folder.path() / "rig.yml").views.at(0);
  // the lens is known to half a percent
  const double distance = truth.Center().norm();
  EXPECT_LT((placed.Center() - truth.Center()).norm(), 0.01 * distance);

  // the lens alone, which is no calibration of a rig, but serves as --lenses the next time
  const RunResult lens = RunProgram(
      {"keypose-calibrate", "--lenses", "boards", "--calibration", "lens.yml"}, folder.path());
  ASSERT_EQ(lens.exit_code, 0) << lens.output;
  EXPECT_THROW(ReadRigCalibration(folder.path() / "lens.yml"), InputError);
  const RunResult again = RunProgram({"keypose-calibrate", "--lenses", "lens.yml", "--points",
                                      "points.json", "--calibration", "again.yml"},
                                     folder.path());
  ASSERT_EQ(again.exit_code, 0) << again.output;
  EXPECT_EQ(ReadFile(folder.path() / "again.yml"), ReadFile(folder.path() / "rig.yml"));
}

/// Four webcams of 640 x 480 on an arc, the second and the fourth turned by a quarter.
std::vector<View> Webcams() {
  std::vector<View> views;
  constexpr double kRolls[] = {0, 90, 0, -90};
  for (int c = 0; c < 4; ++c) {
    const double a = 0.4 * c - 0.6;
    View view;
    view.name = "port_" + std::to_string(c);
    view.camera = {640, 480, 620, 620, 324, 237, 0, 0, 0, 0};
    const Eigen::Quaterniond roll(
        Eigen::AngleAxisd(kRolls[c] * std::numbers::pi / 180, Eigen::Vector3d::UnitZ()));
    view.camera_from_world =
        Compose({roll, Eigen::Vector3d::Zero()},
                LookAt({2 * std::sin(a), -1.9 * std::cos(a), 1 + 0.15 * c}, {0, 0, 0.75}));
    views.push_back(view);
  }
  return views;
}

/// What a webcam sees of a board that is moved through the room, at a time.
Image8 MovedBoard(const capture::BoardPattern& board, const View& webcam, double t, int seed) {
  Rigid3 world_from_board;
  world_from_board.rotation =
      Eigen::AngleAxisd(0.5 * std::sin(1.7 * t), Eigen::Vector3d::UnitZ()) *
      Eigen::AngleAxisd(1.0 + 0.4 * std::sin(0.9 * t), Eigen::Vector3d::UnitX()) *
      Eigen::AngleAxisd(0.4 * std::cos(1.3 * t), Eigen::Vector3d::UnitY());
  world_from_board.translation = {0.3 * std::sin(0.7 * t), 0.25 * std::cos(1.1 * t) - 0.2,
                                  0.75 + 0.3 * std::sin(0.5 * t)};
  capture::Seeing seeing;
  seeing.view = webcam, seeing.noise = 3, seeing.blur_px = 0.8;
  seeing.view.camera_from_world = Compose(webcam.camera_from_world, world_from_board);
  return capture::Photograph(board, seeing, seed);
}

/// A board of an afternoon's print, inverted, held into the room in so many places.
void FilmBoard(const std::vector<View>& webcams, const fs::path& shot, int frames) {
  capture::BoardPattern board = capture::Charuco(4, 5, 0);  // DICT_4X4_50
  board.inverted = true;
  for (int f = 0; f < frames; ++f)
    for (int c = 0; c < 4; ++c) {
      const fs::path folder = shot / webcams[c].name;
      fs::create_directories(folder);
      WriteImage(folder / (std::to_string(f) + ".png"),
                 MovedBoard(board, webcams[c], f, 4 * f + c + 1));
    }
}

TEST(CalibrateProgram, AnInvertedBoardInFourWebcamsTwoOfThemTurnedPlacesThem) {
  const TestingFolder folder;
  const std::vector<View> truth = Webcams();
  FilmBoard(truth, folder.path() / "shot", 16);
  const RunResult run = RunProgram({"keypose-calibrate", "--video", "shot", "--calibration",
                                    "rig.yml", "--every", "1", "--board_square_mm", "50"},
                                   folder.path());
  ASSERT_EQ(run.exit_code, 0) << run.output;
  EXPECT_NE(run.output.find("a ChArUco board of 4 x 5 squares, DICT_4X4_50, printed inverted"),
            std::string::npos)
      << run.output;
  const std::vector<View> found = ReadRigCalibration(folder.path() / "rig.yml").views;
  ASSERT_EQ(found.size(), 4u);
  PointsX3 centers(4, 3), expected(4, 3);
  for (int c = 0; c < 4; ++c) {
    EXPECT_NEAR(found[c].camera.fx, 620, 6) << c;
    centers.row(c) = found[c].Center().transpose(), expected.row(c) = truth[c].Center().transpose();
  }
  const Similarity3 moved = FitSimilarity(centers, expected, {}, false);
  // squares of 11 to 25 pixels tell a webcam's distance to half a percent
  EXPECT_LT((Transformed(moved, centers) - expected).rowwise().norm().maxCoeff(), 0.012);
}

constexpr int kEvery = 4;  // picture of a film is looked at

/// A board that is moved through the room for five seconds, and a clap in it, as two
/// webcams of ten pictures a second film it; the second one is started `late_s` after the first.
void FilmMovedBoard(const std::vector<View>& webcams, const fs::path& shot, double late_s) {
  constexpr int kRate = 10, kSound = 16000;
  fs::create_directories(shot);
  for (int c = 0; c < 2; ++c) {
    TestFilmKind kind;
    kind.width = 640, kind.height = 480, kind.rate = kRate, kind.sound_rate = kSound;
    TestFilm film(shot / (webcams[c].name + ".mkv"), kind);
    std::mt19937 random(static_cast<unsigned>(c));
    std::normal_distribution<double> noise(0, 1);
    std::vector<double> sound;
    for (int i = 0; i < 5 * kSound; ++i) {
      const double after = c * late_s + static_cast<double>(i) / kSound - 3;
      sound.push_back(0.1 * (after > 0 ? std::exp(-after / 0.05) : 0) + 0.001);
      sound.back() *= std::clamp(noise(random), -3.0, 3.0);
    }
    film.AddSound(sound);
    Image8 picture;
    for (int f = 0; f < 5 * kRate; ++f) {
      // between the pictures that are looked at, the film stands still
      if (f % kEvery == 0)
        picture = MovedBoard(capture::Charuco(4, 5, 0), webcams[c],
                             c * late_s + static_cast<double>(f) / kRate, 2 * f + c);
      film.Add(std::int64_t{f} * kind.unit / kRate, [&](AVFrame& frame) {
        for (int y = 0; y < 480; ++y)
          for (int x = 0; x < 640; ++x)
            frame.data[0][y * frame.linesize[0] + x] =
                static_cast<std::uint8_t>(16 + *picture.at(x, y) * 219 / 255);
        for (int plane = 1; plane < 3; ++plane)
          std::fill_n(frame.data[plane], frame.linesize[plane] * 240, std::uint8_t{128});
      });
    }
    film.Finish();
  }
}

TEST(CalibrateProgram, WebcamsThatWereStartedByHandAreJoinedByAClap) {
  constexpr double kLate_s = 1.204;
  const TestingFolder folder;
  std::vector<View> truth = Webcams();
  truth.erase(truth.begin() + 1), truth.resize(2);  // neither lies on its side
  FilmMovedBoard(truth, folder.path() / "shot", kLate_s);
  const auto calibrate = [&](const std::string& offsets) {
    return RunProgram(
        {"keypose-calibrate", "--video", "shot", "--calibration", "rig.yml", "--every",
         std::to_string(kEvery), "--board_square_mm", "50", "--clock_offsets", offsets},
        folder.path());
  };
  const RunResult run = calibrate("auto");
  ASSERT_EQ(run.exit_code, 0) << run.output;
  std::smatch said;
  ASSERT_TRUE(std::regex_search(run.output, said,
                                std::regex("by sound: port_0 at 0.000 s, port_2 at ([0-9.]+) s")))
      << run.output;
  EXPECT_NEAR(std::stod(said[1]), kLate_s, 0.002);
  const auto distance_of = [](const std::vector<View>& views) {
    return (views.at(0).Center() - views.at(1).Center()).norm();
  };
  // pictures lie up to 4 ms apart, in which the board moves by 2 mm
  EXPECT_NEAR(distance_of(ReadRigCalibration(folder.path() / "rig.yml").views), distance_of(truth),
              0.02);
  const std::string joined = ReadFile(folder.path() / "rig.yml");
  ASSERT_EQ(calibrate("0,1.204").exit_code, 0);
  EXPECT_EQ(ReadFile(folder.path() / "rig.yml"), joined) << "the same pictures";
  EXPECT_EQ(calibrate("soon").exit_code, 2);
}

TEST(CalibrateProgram, NothingToCalibrateFromIsAUsageError) {
  const TestingFolder folder;
  const RunResult run =
      RunProgram({"keypose-calibrate", "--calibration", "rig.yml"}, folder.path());
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_NE(run.output.find("--points"), std::string::npos) << run.output;
}

}  // namespace keypose::tests::calibrate_program_test
