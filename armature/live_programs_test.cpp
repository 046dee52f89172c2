// `keypose armature bake` and `live` as programs, on the generated theropod.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "armature/description/description_file.h"
#include "armature/example/theropod.h"
#include "armature/recording/joint_curves.h"
#include "core/io/meshes/bvh_io.h"
#include "core/io/meshes/mesh_io.h"
#include "core/io/pictures/frame_folder.h"
#include "core/io/pictures/image_io.h"
#include "core/io/text/files.h"
#include "core/testing/folder.h"
#include "core/testing/paths.h"
#include "core/values/camera.h"

namespace keypose::armature::live_programs_test {

namespace fs = std::filesystem;

class LivePrograms : public ::testing::Test {
 protected:
  LivePrograms() {
    if (!fs::exists(folder_ / "t")) {
      EXPECT_EQ(Run("example --folder " + Path("t") + " --vertices 3000"), 0) << Err();
    }
  }
  ~LivePrograms() override {
    for (const auto& entry : fs::directory_iterator(folder_))
      if (entry.path().filename() != "t") fs::remove_all(entry.path());
  }
  static void SetUpTestSuite() { made_ = std::make_unique<TestingFolder>(); }
  static void TearDownTestSuite() { made_.reset(); }

  std::string Path(const std::string& name) const { return (folder_ / name).string(); }
  std::string Puppet() const {
    return " --description " + Path("t/theropod.txt") + " --chains " +
           Path("t/theropod_chains.txt") + " --skeleton " + Path("t/theropod.bvh");
  }
  /// @return the exit code; what it printed is in out and err
  int Run(const std::string& command, const std::string& input = "/dev/null") {
    const int status = std::system((BinFolder() + "/keypose-armature " + command + " <" + input +
                                    " >" + Path("out") + " 2>" + Path("err"))
                                       .c_str());
    return WEXITSTATUS(status);
  }
  std::string Err() const { return ReadFile(folder_ / "err"); }

  /// @param rests_at  this frame has the pose of the one before; -1: none
  void WriteCurves(int frames, int step, int rests_at = -1) {
    const Armature armature = MakeTheropod();
    JointCurves curves;
    curves.step = step;
    for (const int node : armature.joints) curves.joints.push_back(armature.nodes[node].name);
    curves.values.resize(frames, static_cast<Eigen::Index>(armature.joints.size()));
    for (int f = 0; f < frames; ++f) {
      const auto values = TheropodWalk(armature, (f == rests_at ? f - 1 : f) / 12.0);
      curves.values.row(f) =
          Eigen::Map<const Eigen::RowVectorXd>(values.data(), std::ssize(values));
    }
    WriteFile(folder_ / "curves.json", CurvesJson(armature, curves));
  }

  /// Of all these tests: the example is made once.
  static inline std::unique_ptr<TestingFolder> made_;
  const fs::path folder_ = made_->path();
};

TEST_F(LivePrograms, BakeHoldsFramesOnTwos) {
  WriteCurves(4, 2);
  ASSERT_EQ(Run("bake" + Puppet() + " --mesh " + Path("t/theropod.ply") + " --curves " +
                Path("curves.json") + " --frames " + Path("frames") + " --motion " +
                Path("motion.bvh") + " --rest " + Path("rest.ply")),
            0)
      << Err();
  const auto frames = NumberedFrames(folder_ / "frames", "test");
  ASSERT_EQ(frames.size(), 8u);
  EXPECT_EQ(FrameRateOf(folder_ / "frames"), 24);
  const Mesh rest = ReadMesh(folder_ / "rest.ply"), one = ReadMesh(frames[2]);
  EXPECT_EQ(rest.faces, one.faces);
  EXPECT_EQ(one.points, ReadMesh(frames[3]).points);
  EXPECT_NE(one.points, ReadMesh(frames[4]).points);
  EXPECT_EQ(ReadBvh(folder_ / "motion.bvh").frame_count(), 8);
}

TEST_F(LivePrograms, AnEditedTakeIsANewOne) {
  WriteCurves(6, 1);
  const std::string before = ReadFile(folder_ / "curves.json");
  WriteFile(folder_ / "edits.txt", "step 2       # on twos\nhold all 1-2\n");
  const std::string command = "edit --description " + Path("t/theropod.txt") + " --curves " +
                              Path("curves.json") + " --edits " + Path("edits.txt") + " --take " +
                              Path("take2");
  ASSERT_EQ(Run(command), 0) << Err();
  EXPECT_EQ(ReadFile(folder_ / "curves.json"), before) << "the first take stays";
  const Armature armature = MakeTheropod();
  const JointCurves old = ParseCurvesJson(before, "old", armature),
                    edited =
                        ParseCurvesJson(ReadFile(folder_ / "take2/curves.json"), "new", armature);
  EXPECT_EQ(edited.step, 2);
  ASSERT_EQ(edited.frame_count(), 3);
  EXPECT_EQ(edited.values.row(2), old.values.row(2));
  EXPECT_EQ(ReadBvh(folder_ / "take2/curves.bvh").frame_count(), 6);
  EXPECT_TRUE(fs::exists(folder_ / "take2/flipbook.svg"));
  EXPECT_EQ(ReadFile(folder_ / "take2/edits.txt"), ReadFile(folder_ / "edits.txt"));
  WriteFile(folder_ / "edits.txt", "hold tail 0-1\n");
  EXPECT_EQ(Run(command), 3);
  EXPECT_NE(Err().find("edits.txt, line 1: no joint is called 'tail'"), std::string::npos) << Err();
}

TEST_F(LivePrograms, ATakeIsDraftedAsItsChangesWouldMakeIt) {
  WriteCurves(6, 2);
  WriteFile(folder_ / "edits.txt", "delete 0\nset leftKneeBend 2 -41.5\n");
  WriteFile(folder_ / "bad.txt", "set leftKneeBend 2 1\n");
  const auto question = [&](const std::string& edits, const std::string& to) {
    return nlohmann::json{{"edits", edits}, {"to", Path(to)}}.dump() + "\n";
  };
  WriteFile(folder_ / "in", question("", "plain") + question(Path("bad.txt"), "beyond") +
                                "nonsense\n" + question(Path("edits.txt"), "draft"));
  ASSERT_EQ(Run("drafts" + Puppet() + " --curves " + Path("curves.json"), Path("in")), 0) << Err();
  std::istringstream answers(ReadFile(folder_ / "out"));
  std::vector<nlohmann::json> told;
  for (std::string line; std::getline(answers, line);) told.push_back(nlohmann::json::parse(line));
  ASSERT_EQ(told.size(), 4u);
  EXPECT_EQ(told[0]["frames"], 6);
  EXPECT_NE(told[1]["error"].get<std::string>().find("its limits are -150 to 0"),
            std::string::npos);
  EXPECT_NE(told[2]["error"].get<std::string>().find("no question"), std::string::npos);
  EXPECT_EQ(told[3]["frames"], 5);
  EXPECT_FALSE(fs::exists(folder_ / "beyond"));
  const std::string plain_bytes = ReadFile(folder_ / "plain"),
                    draft_bytes = ReadFile(folder_ / "draft");
  const std::size_t plain_end = plain_bytes.find('\n') + 1, end = draft_bytes.find('\n') + 1;
  EXPECT_EQ(plain_end % 4, 0u);
  EXPECT_EQ(end % 4, 0u);
  const auto plain = nlohmann::json::parse(plain_bytes.substr(0, plain_end)),
             draft = nlohmann::json::parse(draft_bytes.substr(0, end));
  EXPECT_EQ(draft["step"], 2);
  EXPECT_EQ(draft["fps"], 24);
  ASSERT_EQ(draft["joints"].size(), 74u);
  for (std::size_t j = 0; j < 74; ++j) {
    const nlohmann::json& joint = draft["joints"][j];
    ASSERT_EQ(joint["values"].size(), 5u);
    const bool knee = joint["name"] == "leftKneeBend";
    EXPECT_EQ(joint["unit"], j < 3 ? "mm" : "degrees");
    EXPECT_EQ(joint["values"][2], knee ? nlohmann::json(-41.5) : plain["joints"][j]["values"][3]);
    EXPECT_EQ(joint["values"][0], plain["joints"][j]["values"][1]);
    if (!knee) continue;
    EXPECT_EQ(joint["low"], -150);
    EXPECT_EQ(joint["high"], 0);
  }
  EXPECT_TRUE(draft["joints"][0]["low"].is_null());
  // The poses are those of the frames that stay, but for the one that was set.
  const std::string all = plain_bytes.substr(plain_end), rest = draft_bytes.substr(end);
  const std::size_t pose = all.size() / 6;
  ASSERT_EQ(rest.size(), 5 * pose);
  EXPECT_EQ(pose % 28, 0u);
  EXPECT_EQ(rest.substr(0, pose), all.substr(pose, pose));
  EXPECT_NE(rest.substr(2 * pose, pose), all.substr(3 * pose, pose));
}

/// 7 numbers a bone, frame after frame: turn w x y z, then shift.
std::vector<Rigid3> BonesIn(const std::vector<float>& numbers, std::size_t frame,
                            std::size_t bones) {
  std::vector<Rigid3> all(bones);
  for (std::size_t b = 0; b < bones; ++b) {
    const float* n = numbers.data() + 7 * (frame * bones + b);
    all[b].rotation = Eigen::Quaterniond(n[0], n[1], n[2], n[3]).normalized();
    all[b].translation = {n[4], n[5], n[6]};
  }
  return all;
}

/// How far the posed points are from where a bone takes them, at the bone that fits best; each
/// vertex of a figure of sticks follows one.
double FarthestFromBones(const PointsX3& rest, const PointsX3& posed,
                         const std::vector<Rigid3>& bones) {
  double farthest = 0;
  for (Eigen::Index v = 0; v < rest.rows(); ++v) {
    double nearest = 1e300;
    for (const Rigid3& bone : bones) {
      const Eigen::Vector3d at = bone * Eigen::Vector3d(rest.row(v).transpose());
      nearest = std::min(nearest, (at - posed.row(v).transpose()).norm());
    }
    farthest = std::max(farthest, nearest);
  }
  return farthest;
}

TEST_F(LivePrograms, ADraftPlaysWhatBakeMakes) {
  WriteCurves(4, 4);
  const std::string from = Puppet() + " --curves " + Path("curves.json");
  for (const std::string between : {"linear", "smooth"}) {
    WriteFile(
        folder_ / "in",
        nlohmann::json{{"edits", ""}, {"to", Path("draft")}, {"between", between}}.dump() + "\n");
    ASSERT_EQ(Run("drafts" + from, Path("in")), 0) << Err();
    ASSERT_EQ(Run("bake" + from + " --overwrite --between " + between + " --frames " +
                  Path("frames") + " --rest " + Path("rest.ply")),
              0)
        << Err();
    const std::string bytes = ReadFile(folder_ / "draft");
    const std::size_t begin = bytes.find('\n') + 1;
    const auto told = nlohmann::json::parse(bytes.substr(0, begin));
    const auto baked = NumberedFrames(folder_ / "frames", "test");
    ASSERT_EQ(told["film"], 13);
    ASSERT_EQ(baked.size(), 13u);
    std::vector<float> numbers((bytes.size() - begin) / 4);
    std::memcpy(numbers.data(), bytes.data() + begin, 4 * numbers.size());
    // Four recorded frames, then the film's bones, then the values of 74 joints in it.
    const std::size_t values = 13 * 74, bones = (numbers.size() - values) / (17 * 7);
    ASSERT_EQ(numbers.size(), 17 * 7 * bones + values);
    const PointsX3 rest = ReadMesh(folder_ / "rest.ply").points;
    for (const std::size_t f : {0, 1, 5, 6, 12})
      EXPECT_LT(FarthestFromBones(rest, ReadMesh(baked[f]).points, BonesIn(numbers, 4 + f, bones)),
                1e-5)
          << between << " " << f;
    EXPECT_GT(FarthestFromBones(rest, ReadMesh(baked[6]).points, BonesIn(numbers, 4 + 4, bones)),
              1e-4);
    // Values: at recorded frames the recorded ones; half-way, at even pace, the mean of two.
    const float* film = numbers.data() + 17 * 7 * bones;
    for (std::size_t j = 0; j < 74; ++j) {
      const nlohmann::json& recorded = told["joints"][j]["values"];
      EXPECT_NEAR(film[8 * 74 + j], recorded[2].get<double>(), 1e-4);
      const double mean = (recorded[1].get<double>() + recorded[2].get<double>()) / 2;
      if (between == "linear") {
        EXPECT_NEAR(film[6 * 74 + j], mean, 1e-4);
      }
    }
  }
}

/// The largest change of a bone's way from one picture to the next: at recorded frames, elsewhere.
std::pair<double, double> SeamsOf(const std::vector<std::vector<Rigid3>>& film, std::size_t step) {
  double at_recorded = 0, elsewhere = 0;
  for (std::size_t f = 1; f + 1 < film.size(); ++f)
    for (std::size_t b = 0; b < film[f].size(); ++b) {
      // A place beside the bone, so that its turn counts too.
      const Eigen::Vector3d place(0.1, 0.1, 0.1),
          before = film[f - 1][b] * place, now = film[f][b] * place, after = film[f + 1][b] * place;
      double& most = f % step == 0 ? at_recorded : elsewhere;
      most = std::max(most, (after - 2 * now + before).norm());
    }
  return {at_recorded, elsewhere};
}

TEST_F(LivePrograms, ASmoothFilmHasNoSeamsAtRecordedFrames) {
  WriteCurves(16, 4);
  for (const std::string between : {"linear", "smooth"}) {
    WriteFile(folder_ / "in",
              nlohmann::json{{"edits", ""}, {"to", Path("draft")}, {"between", between}}.dump());
    ASSERT_EQ(Run("drafts" + Puppet() + " --curves " + Path("curves.json"), Path("in")), 0)
        << Err();
    const std::string bytes = ReadFile(folder_ / "draft");
    const std::size_t begin = bytes.find('\n') + 1;
    std::vector<float> numbers((bytes.size() - begin) / 4);
    std::memcpy(numbers.data(), bytes.data() + begin, 4 * numbers.size());
    const std::size_t bones = (numbers.size() - 61 * 74) / ((16 + 61) * 7);
    std::vector<std::vector<Rigid3>> film;
    for (std::size_t f = 0; f < 61; ++f) film.push_back(BonesIn(numbers, 16 + f, bones));
    const auto [at_recorded, elsewhere] = SeamsOf(film, 4);
    if (between == "smooth")
      EXPECT_LT(at_recorded, 1.1 * elsewhere);
    else
      EXPECT_GT(at_recorded, 3 * elsewhere) << "as a test of the measure";
  }
}

TEST_F(LivePrograms, ADraftOfNoFilmSaysWhy) {
  WriteCurves(2, 1);
  WriteFile(folder_ / "in",
            nlohmann::json{{"edits", ""}, {"to", Path("draft")}, {"between", "jumps"}}.dump());
  ASSERT_EQ(Run("drafts" + Puppet() + " --curves " + Path("curves.json"), Path("in")), 0) << Err();
  EXPECT_NE(ReadFile(folder_ / "out").find("not 'jumps'"), std::string::npos);
}

TEST_F(LivePrograms, TheFilesOfATakeAreFound) {
  WriteCurves(2, 1);
  const auto puppets = [&](const std::string& folder) {
    EXPECT_EQ(Run("files --folder " + Path(folder) + " --curves " + Path("curves.json")), 0)
        << Err();
    return nlohmann::json::parse(ReadFile(folder_ / "out"))["puppets"];
  };
  // What is no description, or one of another puppet, or not whole, is passed over.
  const std::string description = ReadFile(folder_ / "t/theropod.txt");
  fs::create_directories(folder_ / "p/deep/more");
  WriteFile(folder_ / "p/another.txt", "node {\n  name knee\n  axis 1 0 0\n  sensor 0\n}\n");
  WriteFile(folder_ / "p/broken.txt", description.substr(0, description.size() / 2));
  WriteFile(folder_ / "p/notes.txt", "buy clay\n");
  WriteFile(folder_ / "p/empty.bvh", "");
  fs::create_symlink(folder_ / "t/theropod.txt", folder_ / "p/link.txt");
  EXPECT_TRUE(puppets("p").empty());
  fs::copy(folder_ / "t/theropod.txt", folder_ / "p/deep/more/it.txt");
  EXPECT_TRUE(puppets("p").empty()) << "without chains nothing can be shown";
  fs::copy(folder_ / "t/theropod_chains.txt", folder_ / "p/ways.txt");
  auto found = puppets("p");
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0]["description"], Path("p/deep/more/it.txt"));
  EXPECT_EQ(found[0]["chains"], Path("p/ways.txt"));
  EXPECT_EQ(found[0]["skeleton"], "");
  fs::copy(folder_ / "t/theropod.bvh", folder_ / "p/rig.bvh");
  EXPECT_EQ(puppets("p")[0]["skeleton"], Path("p/rig.bvh"));
  // Those beside the description come first.
  fs::copy(folder_ / "t/theropod_chains.txt", folder_ / "p/deep/more/z.txt");
  EXPECT_EQ(puppets("p")[0]["chains"], Path("p/deep/more/z.txt"));
  EXPECT_EQ(Run("files --folder " + Path("nowhere") + " --curves " + Path("curves.json")), 4);
  EXPECT_EQ(Run("files --folder " + Path("p") + " --curves " + Path("nowhere")), 4);
}

TEST_F(LivePrograms, ACharacterIsWrittenForAPage) {
  ASSERT_EQ(Run("show" + Puppet() + " --mesh " + Path("t/theropod.ply") + " --plate " +
                Path("t/plate.png") + " --shot " + Path("t/shot.json") + " --page " + Path("page")),
            0)
      << Err();
  const auto view = nlohmann::json::parse(ReadFile(folder_ / "page/view.json"));
  EXPECT_EQ(view["sensors"].size(), 74u);
  EXPECT_EQ(view["pictures"].size(), 1u);
  EXPECT_EQ(fs::file_size(folder_ / "page/weights.bin"), 24 * view["vertices"].get<std::size_t>());
}

TEST_F(LivePrograms, BakeGoesSmoothlyBetweenKeys) {
  WriteCurves(3, 1);
  ASSERT_EQ(Run("bake --description " + Path("t/theropod.txt") + " --chains " +
                Path("t/theropod_chains.txt") + " --curves " + Path("curves.json") + " --frames " +
                Path("frames") + " --between smooth --step 5 --fps 30"),
            0)
      << Err();
  EXPECT_EQ(NumberedFrames(folder_ / "frames", "test").size(), 11u);
  EXPECT_EQ(FrameRateOf(folder_ / "frames"), 30);
}

TEST_F(LivePrograms, RecordedPosesAreKeysForInterpolate) {
  // Five recorded frames on fours, of which two are one pose.
  WriteCurves(5, 4, 2);
  ASSERT_EQ(Run("bake" + Puppet() + " --mesh " + Path("t/theropod.ply") + " --curves " +
                Path("curves.json") + " --between keys --frames " + Path("keys") + " --timeline " +
                Path("timeline.json")),
            0)
      << Err();
  const auto keys = NumberedFrames(folder_ / "keys", "test");
  ASSERT_EQ(keys.size(), 4u);
  std::string command = BinFolder() + "/keypose-interpolate";
  for (const fs::path& key : keys) command += " --keys " + key.string();
  command += " --timeline " + Path("timeline.json") + " --frames " + Path("frames") + " 2> " +
             Path("err") + " > " + Path("out");
  ASSERT_EQ(std::system(command.c_str()), 0) << Err();
  const auto frames = NumberedFrames(folder_ / "frames", "test");
  ASSERT_EQ(frames.size(), 17u);  // from recorded frame 0 to 4, four film frames each
  const std::size_t at[] = {0, 4, 12, 16};
  for (std::size_t k = 0; k < 4; ++k)
    EXPECT_EQ(ReadMesh(frames[at[k]]).points, ReadMesh(keys[k]).points) << k;
  // The puppet rested from recorded frame 1 to 2: a hard stop, to the bit.
  for (std::size_t f = 5; f <= 8; ++f)
    EXPECT_EQ(ReadMesh(frames[f]).points, ReadMesh(keys[1]).points) << f;
  EXPECT_NE(ReadMesh(frames[9]).points, ReadMesh(keys[1]).points);
  EXPECT_EQ(FrameRateOf(folder_ / "frames"), 24);
}

TEST_F(LivePrograms, BakeRefusesTimelinesWithoutKeys) {
  const std::string ends = Puppet() + " --curves " + Path("curves.json") + " --frames " +
                           Path("keys") + " --timeline " + Path("timeline.json");
  WriteCurves(2, 1);
  EXPECT_EQ(Run("bake" + ends), 2);
  EXPECT_NE(Err().find("between keys"), std::string::npos);
  WriteCurves(1, 1);
  EXPECT_EQ(Run("bake" + ends + " --between keys"), 3);
  EXPECT_NE(Err().find("one pose"), std::string::npos);
  EXPECT_FALSE(fs::exists(folder_ / "timeline.json"));
}

TEST_F(LivePrograms, BakeSaysWhatIsWrong) {
  WriteCurves(2, 1);
  const std::string out = " --frames " + Path("frames");
  EXPECT_EQ(Run("bake" + Puppet() + " --curves " + Path("t/theropod.bvh") + out), 3);
  EXPECT_NE(Err().find("theropod.bvh"), std::string::npos);
  WriteFile(folder_ / "w.json", R"({"weights": {"Hips": [[0, 1]]}})");
  EXPECT_EQ(Run("bake" + Puppet() + " --mesh " + Path("t/theropod.ply") + " --weights " +
                Path("w.json") + " --curves " + Path("curves.json") + out),
            3);
  EXPECT_NE(Err().find("no bone moves vertex 1"), std::string::npos);
  EXPECT_EQ(Run("bake" + Puppet() + " --weights " + Path("w.json") + " --curves " +
                Path("curves.json") + out),
            2);
  EXPECT_EQ(Run("bake" + Puppet() + " --curves " + Path("curves.json") + out + " --between jumps"),
            2);
  EXPECT_FALSE(fs::exists(folder_ / "frames"));
}

TEST_F(LivePrograms, LiveStreamsRecordsAndDraws) {
  WriteFile(folder_ / "typed", "back\nplate 0\nplate 9\nnonsense\nrecord\n");
  ASSERT_EQ(
      Run("live" + Puppet() + " --port simulated --seconds 3 --mesh " + Path("t/theropod.ply") +
              " --session " + Path("session") + " --pictures " + Path("pictures"),
          Path("typed")),
      0)
      << Err();
  std::ifstream lines(folder_ / "out");
  int poses = 0, recorded = 0, pictures = 0, refused = 0;
  nlohmann::json last;
  for (std::string line; std::getline(lines, line);) {
    last = nlohmann::json::parse(line);
    poses += last.contains("pose") && last.contains("joints");
    if (!last.contains("event")) continue;
    recorded += last["event"] == "recorded";
    pictures += last["event"] == "picture";
    refused += last["event"] == "refused";
  }
  EXPECT_GT(poses, 5);
  EXPECT_GE(recorded, 1);
  EXPECT_EQ(refused, 2);
  EXPECT_GE(pictures, 1);
  EXPECT_EQ(last["event"], "ended");
  EXPECT_EQ(last["pictures"], pictures);
  EXPECT_EQ(ReadImage(folder_ / "pictures" / "picture_00000.png").channels, 3);
  const auto curves =
      ParseCurvesJson(ReadFile(folder_ / "session" / "curves.json"), "curves", MakeTheropod());
  EXPECT_EQ(curves.frame_count(), 1);
}

TEST_F(LivePrograms, LiveTellsAPageAllThatItShows) {
  // Its input is a pipe: the program ends when that does.
  WriteFile(folder_ / "typing",
            "sleep 1; echo record; sleep 1.5; echo record; sleep 1.5; echo zero leftKneeBend; "
            "echo zero nobody; sleep 0.5");
  const std::string command = "live" + Puppet() +
                              " --port simulated --simulated frames --faults wrap@0 --mesh " +
                              Path("t/theropod.ply") + " --session " + Path("session") +
                              " --page_rate 20 --rate 60 --page " + Path("page");
  const std::string shell = "sh " + Path("typing") + " | " + BinFolder() + "/keypose-armature " +
                            command + " > " + Path("out") + " 2> " + Path("err");
  ASSERT_EQ(WEXITSTATUS(std::system(shell.c_str())), 0) << Err();
  std::ifstream lines(folder_ / "out");
  nlohmann::json pose;
  std::vector<std::string> events;
  for (std::string line; std::getline(lines, line);) {
    const nlohmann::json told = nlohmann::json::parse(line);
    if (told.contains("pose")) pose = told;
    if (told.contains("event")) events.push_back(told["event"]);
  }
  const auto view = nlohmann::json::parse(ReadFile(folder_ / "page/view.json"));
  const std::size_t bones = view["bones"], vertices = view["vertices"];
  EXPECT_EQ(view["sensors"].size(), 74u);
  EXPECT_EQ(pose["values"].size(), 74u);
  EXPECT_EQ(pose["bones"].size(), 7 * bones);
  EXPECT_EQ(pose["chains"].size(), view["chains"].size());
  EXPECT_EQ(pose["wraps"].size(), 74u);
  EXPECT_EQ(view["chains"][0]["exact"], false);
  EXPECT_EQ(view["chains"][2]["exact"], true);
  EXPECT_EQ(fs::file_size(folder_ / "page/weights.bin"), 24 * vertices);
  const auto count = [&](const char* name) {
    return std::count(events.begin(), events.end(), name);
  };
  EXPECT_EQ(count("session"), 1);
  EXPECT_EQ(count("set"), 1);
  EXPECT_EQ(count("refused"), 1);
  const auto recorded = static_cast<std::size_t>(count("recorded"));
  ASSERT_GE(recorded, 1u);
  EXPECT_EQ(fs::file_size(folder_ / "page/frames.bin"), 4 * 7 * bones * recorded);
  // What a page is told of frames recorded before is what it was told of them then.
  const std::string before = ReadFile(folder_ / "page/frames.bin");
  ASSERT_EQ(Run(command), 0) << Err();
  const std::string after = ReadFile(folder_ / "page/frames.bin");
  ASSERT_EQ(after.size(), before.size());
  for (std::size_t i = 0; i < after.size(); i += 4) {
    float one = 0, two = 0;
    std::memcpy(&one, &before[i], 4);
    std::memcpy(&two, &after[i], 4);
    ASSERT_NEAR(one, two, 1e-5) << i;
  }
}

TEST_F(LivePrograms, LiveRefusesWhatIsNotThere) {
  EXPECT_EQ(Run("live" + Puppet() + " --port /dev/no-such-port --calibration " + Path("c.json")),
            4);
  EXPECT_EQ(Run("live" + Puppet() + " --port simulated --mesh " + Path("none.ply")), 4);
  EXPECT_EQ(Run("live" + Puppet() + " --port simulated --method best"), 2);
  EXPECT_EQ(Run("live --port simulated"), 2);
  EXPECT_EQ(Run("live" + Puppet() + " --port simulated --simulated frames"), 2);
}

}  // namespace keypose::armature::live_programs_test
