// The program keypose-composite on a generated shot with known truth, and on input that is wrong.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <chrono>

#include "tests/generated_shot.h"
#include "views/film/mp4.h"
#include "views/shot/shot.h"

namespace keypose::tests::composite_program_test {

using ::testing::HasSubstr;

TEST_F(GeneratedShot, InBetweensAreLikeTheTruthAndFilmedFramesAreUntouched) {
  const RunResult result =
      Composite("out", {{"report", "report.json"}, {"blender", "true"}, {"compare", "true"}});
  ASSERT_EQ(result.exit_code, 0) << result.output;
  for (const auto& [picture, film] : {std::pair{0, 0}, {2, 1}, {4, 2}})
    EXPECT_EQ(ReadFile(folder_ / "out" / fmt::format("{:04}.png", picture)),
              ReadFile(folder_ / "film" / fmt::format("{:04}.png", film)));
  for (const int n : {1, 3}) EXPECT_GT(PsnrOf("out", n), 28) << "picture " << n;
  const json report = json::parse(ReadFile(folder_ / "report.json"))["measurements"];
  EXPECT_EQ(report["filmed"], 3);
  EXPECT_EQ(report["filmed_unchanged"], 3);
  EXPECT_EQ(report["between"], 2);
  ASSERT_EQ(report["joins"].size(), 2u);
  for (const json& join : report["joins"]) {
    EXPECT_GT(join["psnr_db"], 28);
    EXPECT_LT(join["edge_px"], 0.4);
  }
  EXPECT_GT(report["plate_inpainted"], 0) << "the feet never leave some places";
  EXPECT_GT(report["shadow_explained"], 0.5);
  const Image8 layer = ReadImage(folder_ / "out/layers/0001.png", 0);
  EXPECT_EQ(layer.width, 384);
  EXPECT_TRUE(fs::exists(folder_ / "out/compare/0004.png"));
  EXPECT_TRUE(fs::exists(folder_ / "out/blender/shot.py"));
}

TEST_F(GeneratedShot, FollowingTheFilmMendsAnAnimationThatPassesBesideIt) {
  // Between the keys the animation takes another way than what was filmed.
  fs::create_directories(folder_ / "beside");
  for (int n = 0; n < kPictures; ++n) {
    const std::string name = fmt::format("frame_{:04}.ply", n);
    Mesh frame = ReadMesh(folder_ / "frames" / name);
    if (n % 4)
      for (Eigen::Index v = 0; v < frame.points.rows(); ++v)
        frame.points(v, 0) += 0.1 * frame.points(v, 2);
    WriteMesh(folder_ / "beside" / name, frame);
  }
  fs::copy_file(folder_ / "frames/distortion.json", folder_ / "beside/distortion.json");
  ASSERT_EQ(Composite("alone", {{"frames", "beside"}}).exit_code, 0);
  const RunResult result = Composite(
      "followed", {{"frames", "beside"}, {"follow", "true"}, {"report", "followed.json"}});
  ASSERT_EQ(result.exit_code, 0) << result.output;
  EXPECT_GT(PsnrOf("followed", 1), PsnrOf("alone", 1) + 1);
  EXPECT_GT(PsnrOf("followed", 3), PsnrOf("alone", 3) + 1);
  const json measured = json::parse(ReadFile(folder_ / "followed.json"))["measurements"];
  EXPECT_GT(measured["followed_px"], 0.1);
  EXPECT_EQ(measured["filmed_unchanged"], 3);
}

TEST_F(GeneratedShot, AVideosFramesStayAsDecoded) {
  if (!CanWriteMp4()) GTEST_SKIP() << "libavcodec has no x264 here";
  Mp4Writer writer(folder_ / "take.mp4", 384, 216, 12);
  for (const FilmPicture& picture : FilmPictures(folder_ / "film"))
    writer.Add(ReadImage(picture.path, 3));
  writer.Finish();
  const RunResult result = Composite("of_video", {{"plate", "take.mp4"}, {"filmed", "take.mp4"}});
  ASSERT_EQ(result.exit_code, 0) << result.output;
  FrameSource source;
  source.video = folder_ / "take.mp4", source.frames = 3;
  FrameReader reader(source);
  for (int i = 0; i < 3; ++i)
    EXPECT_EQ(ReadImage(folder_ / fmt::format("of_video/{:04}.png", 2 * i), 3).data,
              reader.Read(i, 3).data);
  EXPECT_GT(PsnrOf("of_video", 1), 26) << "the video lost some of what was filmed";
}

TEST_F(GeneratedShot, AGivenPlateLeavesNothingToPaint) {
  const RunResult result = Composite("given", {{"plate", "plate.png"}, {"report", "given.json"}});
  ASSERT_EQ(result.exit_code, 0) << result.output;
  EXPECT_EQ(json::parse(ReadFile(folder_ / "given.json"))["measurements"]["plate_inpainted"], 0);
  for (const int n : {1, 3}) EXPECT_GT(PsnrOf("given", n), 28) << "picture " << n;
}

TEST_F(GeneratedShot, OfSeveralPlatesOfAStillCameraTheFirstIsTaken) {
  fs::create_directories(folder_ / "empty_set");
  fs::copy_file(folder_ / "plate.png", folder_ / "empty_set/take_1.png");
  WritePng(folder_ / "empty_set/take_2.png", Image8(384, 216, 3));
  const std::map<std::string, std::string> quick{{"samples", "1"}};
  std::map<std::string, std::string> several = quick, one = quick;
  several["plate"] = "empty_set", one["plate"] = "plate.png";
  const RunResult result = Composite("several", several);
  ASSERT_EQ(result.exit_code, 0) << result.output;
  EXPECT_THAT(result.output, HasSubstr("of 2 plates the first one, take_1.png, is taken"));
  ASSERT_EQ(Composite("of_one", one).exit_code, 0);
  EXPECT_EQ(ReadFile(folder_ / "several/0001.png"), ReadFile(folder_ / "of_one/0001.png"));
}

TEST_F(GeneratedShot, CtrlCWhileAFilmIsDecodedEndsItAndLeavesNothing) {
  if (!CanWriteMp4()) GTEST_SKIP() << "libavcodec has no x264 here";
  Mp4Writer writer(folder_ / "long.mp4", 64, 48, 12);
  for (int i = 0; i < 6000; ++i) writer.Add(Image8(64, 48, 3, static_cast<std::uint8_t>(i % 200)));
  writer.Finish();
  const fs::path scratch = folder_ / "scratch";
  fs::create_directories(scratch);
  const auto decoded = [&] {
    for (const auto& film : fs::directory_iterator(scratch))
      if (fs::exists(film.path() / "0010.png")) return true;
    return false;
  };
  Program program(Words("stopped", {{"plate", "long.mp4"}, {"filmed", "long.mp4"}}), folder_,
                  {"TMPDIR=" + scratch.string()});
  while (program.running() && !decoded()) usleep(10'000);
  ASSERT_TRUE(program.running());
  const auto asked = std::chrono::steady_clock::now();
  program.SendSignal(SIGINT);
  // If it decoded on, it would find at the end that the film has another size than the shot.
  EXPECT_EQ(program.Wait(60).exit_code, 130);
  EXPECT_LT(std::chrono::steady_clock::now() - asked, std::chrono::seconds(2));
  EXPECT_TRUE(fs::is_empty(scratch));
  EXPECT_FALSE(fs::exists(folder_ / "stopped"));
}

TEST_F(GeneratedShot, AHoldoutKeepsThePropInFront) {
  const Image8 film = ReadImage(folder_ / "film/0001.png", 3);
  Image8 prop(film.width, film.height, 1);
  for (int y = 100; y < 216; ++y)
    for (int x = 150; x < 200; ++x) *prop.at(x, y) = 255;
  WritePng(folder_ / "prop.png", prop);
  const RunResult result = Composite("held", {{"holdout", "prop.png"}});
  ASSERT_EQ(result.exit_code, 0) << result.output;
  const Image8 plate = ReadImage(folder_ / "held/plate.png", 3),
               picture = ReadImage(folder_ / "held/0001.png", 3);
  double worst = 0;
  for (int y = 110; y < 206; ++y)
    for (int x = 155; x < 195; ++x)
      worst = std::max(worst, std::abs(1.0 * picture.at(x, y)[1] - plate.at(x, y)[1]));
  EXPECT_LT(worst, 20) << "grain alone differs";
}

/// A box on the table, 6 cm to each side and 5 cm high.
std::string BoxAt(double x, double y) {
  std::string text;
  for (int i = 0; i < 8; ++i)
    text += fmt::format("v {} {} {}\n", x + (i & 1 ? 0.03 : -0.03), y + (i & 2 ? 0.03 : -0.03),
                        i & 4 ? 0.05 : 0.0);
  for (const char* face : {"1 3 4 2", "5 6 8 7", "1 2 6 5", "3 7 8 4", "1 5 7 3", "2 4 8 6"})
    text += std::string("f ") + face + "\n";
  return text;
}

TEST_F(GeneratedShot, PropsOfTheSetHideTheCharacterAndCatchItsShadow) {
  // One before the character, as the camera sees it; one in its shadow, away from the lamp.
  WriteFile(folder_ / "before.obj", BoxAt(0.03, -0.14));
  WriteFile(folder_ / "beside.obj", BoxAt(0.10, 0.08));
  const std::map<std::string, std::string> flags{{"plate", "plate.png"}};
  const auto with = [&](const char* name, const char* set) {
    std::map<std::string, std::string> all = flags;
    if (set) all["set"] = set;
    const RunResult result = Composite(name, all);
    EXPECT_EQ(result.exit_code, 0) << result.output;
    return ReadAlpha(folder_ / name / "layers/0001.png");
  };
  const Image8 plain = with("plain", nullptr), hidden = with("behind_box", "before.obj"),
               caught = with("on_box", "beside.obj");
  const auto differing = [&](const Image8& other, int least) {
    int count = 0;
    for (std::size_t i = 0; i < plain.data.size(); ++i)
      count += std::abs(int{plain.data[i]} - other.data[i]) >= least;
    return count;
  };
  EXPECT_GT(differing(hidden, 128), 300) << "of the character's pixels are hidden";
  EXPECT_GT(differing(caught, 12), 100) << "the shadow lies on the box instead of the table";
  WriteFile(folder_ / "none.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n");
  EXPECT_EQ(Composite("no_set", {{"set", "none.obj"}}).exit_code, 3);
}

TEST_F(GeneratedShot, TheSameInputGivesTheSameBitsForAnyThreadCount) {
  const std::map<std::string, std::string> quick{{"samples", "2"}, {"follow", "true"}};
  const RunResult one = Composite("one", quick, {"KEYPOSE_THREADS=1"}),
                  three = Composite("three", quick, {"KEYPOSE_THREADS=3"});
  ASSERT_EQ(one.exit_code + three.exit_code, 0) << one.output << three.output;
  for (const char* name : {"0001.png", "0003.png", "layers/0001.png", "plate.png"})
    EXPECT_EQ(ReadFile(folder_ / "one" / name), ReadFile(folder_ / "three" / name)) << name;
}

TEST_F(GeneratedShot, WrongInputIsNamed) {
  const auto refused = [&](const std::map<std::string, std::string>& other, const char* words) {
    const RunResult result = Composite("wrong", other);
    EXPECT_EQ(result.exit_code, 3) << result.output;
    EXPECT_THAT(result.output, HasSubstr(words));
    EXPECT_FALSE(fs::exists(folder_ / "wrong"));
  };
  const Image8 film = ReadImage(folder_ / "film/0000.png", 3);
  fs::create_directories(folder_ / "mixed");
  for (const char* name : {"0000.png", "0001.png", "0002.png"})
    fs::copy_file(folder_ / "film" / name, folder_ / "mixed" / name,
                  fs::copy_options::overwrite_existing);
  WritePng(folder_ / "mixed/0001.png", Resized(film, 192, 108));
  refused({{"filmed", "mixed"}}, "0001.png has 192 x 108 pixels");
  WritePng(folder_ / "small_plate.png", Resized(film, 192, 108));
  refused({{"plate", "small_plate.png"}}, "the plate");
  FilmedShot away = ReadShot(folder_ / "shot.json");
  for (ShotFrame& frame : away.frames) frame.world_from_character.translation.x() = 20;
  WriteFile(folder_ / "away.json", ShotText(away));
  refused({{"shot", "away.json"}}, "the character is in none of the filmed frames");
  FilmedShot moving = ReadShot(folder_ / "shot.json");
  moving.still = false;
  WriteFile(folder_ / "moving.json", ShotText(moving));
  refused({{"shot", "moving.json"}}, "cannot be made from its own frames");
  refused({{"shot", "moving.json"}, {"plate", "plate.png"}}, "one plate");
  refused({{"shot", "moving.json"}, {"filmed", ""}}, "--filmed");
  FilmedShot late = ReadShot(folder_ / "shot.json");
  late.frames.back().frame = 3;
  WriteFile(folder_ / "late.json", ShotText(late));
  refused({{"shot", "late.json"}}, "does not have");
  WriteFile(folder_ / "broken.json", "{\"schema\": 1}");
  refused({{"shot", "broken.json"}}, "broken.json");
}

/// The same, with a camera that swings round the character and comes nearer.
class MovingShot : public GeneratedShot {
 protected:
  static void SetUpTestSuite() {
    synth::ShotCommand command;
    command.swing_deg = 6, command.dolly_m = 0.03;
    Film(command);
    FilmedShot shot = ReadShot(folder_ / "truth/shot/shot.json");  // all that was filmed
    for (ShotFrame& frame : shot.frames) frame.world_from_character = {};
    WriteFile(folder_ / "shot.json", ShotText(shot));
    fs::create_directories(folder_ / "film_plates");  // none between the filmed frames
    for (const auto& [film, picture] : {std::pair{0, 0}, {1, 2}, {2, 4}})
      fs::copy_file(folder_ / fmt::format("plates/{:04}.png", picture),
                    folder_ / fmt::format("film_plates/{:04}.png", film));
  }
};

TEST_F(MovingShot, PlatesAtTheFinishedShotsRateAreUsedAsTheyAre) {
  const RunResult result =
      Composite("passing", {{"plate", "plates"}, {"report", "passing.json"}, {"blender", "true"}});
  ASSERT_EQ(result.exit_code, 0) << result.output;
  for (const int n : {1, 3}) EXPECT_GT(PsnrOf("passing", n), 28) << "picture " << n;
  const json report = json::parse(ReadFile(folder_ / "passing.json"))["measurements"];
  EXPECT_EQ(report["filmed_unchanged"], 3);
  EXPECT_EQ(report["plates_made"], 0);
  EXPECT_GT(report["shadow_explained"], 0.5) << "learnt against each frame's own plate";
  for (const json& join : report["joins"]) {
    EXPECT_GT(join["psnr_db"], 28);
    EXPECT_LT(join["edge_px"], 0.4);
  }
  EXPECT_EQ(ReadImage(folder_ / "passing/plates/0001.png", 3).data,
            ReadImage(folder_ / "plates/0001.png", 3).data);
  EXPECT_FALSE(fs::exists(folder_ / "passing/plate.png"));
  const json blender = json::parse(ReadFile(folder_ / "passing/blender/shot.json"));
  EXPECT_EQ(blender["camera"]["path"].size(), 5u);
}

TEST_F(MovingShot, PlatesOfTheFilmsFramesAreMixedBetween) {
  const std::map<std::string, std::string> flags{{"plate", "film_plates"},
                                                 {"report", "mixed.json"}};
  const RunResult one = Composite("mixed", flags, {"KEYPOSE_THREADS=1"}),
                  three = Composite("mixed3", flags, {"KEYPOSE_THREADS=3"});
  ASSERT_EQ(one.exit_code, 0) << one.output;
  EXPECT_THAT(one.output, HasSubstr("were made from their neighbours"));
  const json report = json::parse(ReadFile(folder_ / "mixed.json"))["measurements"];
  EXPECT_EQ(report["plates_made"], 2);
  EXPECT_GT(PsnrOf("mixed", 1), 25);
  EXPECT_GT(PsnrOf("mixed", 3), 25);
  EXPECT_EQ(ReadFile(folder_ / "mixed/0001.png"), ReadFile(folder_ / "mixed3/0001.png"));
}

TEST_F(MovingShot, AHoldoutThatStandsStillIsToldOf) {
  WritePng(folder_ / "prop.png", Image8(384, 216, 1));
  const RunResult result =
      Composite("with_holdout", {{"plate", "plates"}, {"holdout", "prop.png"}, {"samples", "1"}});
  ASSERT_EQ(result.exit_code, 0) << result.output;
  EXPECT_THAT(result.output, HasSubstr("while the props pass"));
}

TEST_F(MovingShot, CamerasThatWereLocatedServe) {
  const auto at = [](const char* name) { return (folder_ / name).string(); };
  const RunResult located = RunProgram({"keypose-locate",
                                        "--frames",
                                        at("frames"),
                                        "--textures",
                                        at("texture.png"),
                                        "--plate",
                                        at("film"),
                                        "--background",
                                        at("plates"),
                                        "--poses",
                                        "rest,wave",
                                        "--shows",
                                        "0=rest,2=wave",
                                        "--camera",
                                        "moving",
                                        "--focal_35mm",
                                        "50",
                                        "--fps",
                                        "12",
                                        "--shot",
                                        at("located.json"),
                                        "--report",
                                        at("located_report.json")},
                                       folder_);
  ASSERT_EQ(located.exit_code, 0) << located.output;
  // The meshes are in the set's world, so that cameras can be compared. Where the lens's centre is
  // not the picture's, as here, set and character disagree by as much as that.
  const FilmedShot shot = ReadShot(folder_ / "located.json"),
                   truth = ReadShot(folder_ / "truth/shot/shot.json");
  ASSERT_EQ(shot.frames.size(), 3u) << "the frame between is located by the animation";
  for (int i = 0; i < 3; ++i)
    for (const Eigen::Vector3d& point :
         {Eigen::Vector3d(0, 0, 0.02), {0.05, 0, 0.1}, {0, 0.03, 0.16}}) {
      const View mine{"", shot.camera, shot.frames[i].camera_from_world},
          exact{"", truth.camera, truth.frames[i].camera_from_world};
      const Eigen::Vector3d placed = shot.frames[i].world_from_character * point;
      EXPECT_LT((mine.Project(placed) - exact.Project(point)).norm(), 0.8) << i;
      EXPECT_LT((mine.Project(point) - exact.Project(point)).norm(), 2.5) << i;
    }
  const json report = json::parse(ReadFile(folder_ / "located_report.json"))["measurements"];
  EXPECT_GT(report["set_places"], 100);
  EXPECT_LT(report["set_rms_px"], 1);
  ASSERT_EQ(shot.between.size(), 2u) << "each plate between two frames tells its camera";
  EXPECT_EQ(shot.between[0].frame, 0.5);
  const RunResult result = Composite("by_located", {{"plate", "plates"}, {"shot", "located.json"}});
  ASSERT_EQ(result.exit_code, 0) << result.output;
  for (const int n : {1, 3}) EXPECT_GT(PsnrOf("by_located", n), 26) << "picture " << n;
}

TEST_F(MovingShot, AFrameWithoutAPlateIsNamed) {
  fs::create_directories(folder_ / "few");
  for (const char* name : {"0000.png", "0002.png"})
    fs::copy_file(folder_ / "film_plates" / name, folder_ / "few" / name);
  const RunResult result = Composite("none", {{"plate", "few"}});
  EXPECT_EQ(result.exit_code, 3) << result.output;
  EXPECT_THAT(result.output, HasSubstr("no plate for filmed frame 1"));
}

}  // namespace keypose::tests::composite_program_test
