// Picks of a pose, from one file and from two, and what is wrong with files.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/io/project/landmarks_io.h"
#include "core/io/text/files.h"
#include "core/numbers/sha256.h"
#include "core/surfaces/shapes.h"
#include "core/testing/folder.h"
#include "core/values/errors.h"
#include "fit/picks/pose_picks.h"

namespace keypose::fit::pose_picks_test {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

class PosePicksFile : public ::testing::Test, public TestingFolder {
 protected:
  void SetUp() override {
    for (const char* name : {"a.jpg", "b.jpg"}) {
      images_.images.emplace_back();
      images_.images.back().name = name;
      images_.images.back().width = 640;
      images_.images.back().height = 480;
    }
  }

  PosePicks Read(const std::string& text) const {
    return ReadPosePicks({Put("p.json", text)}, mesh_, images_, nullptr);
  }
  /// The message about a file with this list of pixels.
  std::string Fault(const std::string& pixels) const {
    return FaultOf("{\"pixels\": " + pixels + "}");
  }
  std::string FaultOf(const std::string& text) const {
    try {
      Read(text);
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr("p.json"));
      return error.what();
    }
    ADD_FAILURE() << text << " was read";
    return "";
  }

  ImageSet images_;
  const Mesh mesh_ = MakeIcosphere(1);
};

TEST_F(PosePicksFile, OneFileSaysWhereItsPicksAreOnTheTemplate) {
  CarryLog log;
  const PosePicks picks = ReadPosePicks(
      {Put("p.json",
           R"({"pixels": [{"name": "ear", "image": "b.jpg", "pixel": [12.5, 480], "vertex": 7}],
                         "landmarks": [{"name": "toe", "position": [1, 2, 3], "face": 5, "barycentric": [0.25, 0.25, 0.5]}]})")},
      mesh_, images_, &log);
  ASSERT_EQ(picks.pixels.size(), 1u);
  EXPECT_EQ(picks.pixels[0].name, "ear");
  EXPECT_EQ(picks.pixels[0].image, 1);
  EXPECT_EQ(picks.pixels[0].pixel, Eigen::Vector2d(12.5, 480));
  EXPECT_EQ(PositionOf(picks.pixels[0].point, mesh_.points), mesh_.points.row(7).transpose());
  ASSERT_EQ(picks.places.size(), 1u);
  EXPECT_EQ(picks.places[0].target, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(picks.places[0].source.vertices, mesh_.faces.row(5).transpose());
  ASSERT_EQ(log.warnings.size(), 1u);
  EXPECT_THAT(log.warnings[0], HasSubstr("does not say on which mesh"));
}

TEST_F(PosePicksFile, TwoFilesAreJoinedByName) {
  WriteLandmarks(folder_ / "rest.json", mesh_,
                 {{"ear", 3, {0.2, 0.3, 0.5}}, {"nose", 4, {1, 0, 0}}});
  const fs::path pose = Put("pose.json", R"({"pixels": [
      {"name": "ear", "image": "a.jpg", "pixel": [1, 2]}, {"name": "ear", "image": "b.jpg", "pixel": [3, 4]},
      {"name": "tail", "image": "b.jpg", "pixel": [3, 4]}]})");
  CarryLog log;
  const PosePicks picks = ReadPosePicks({folder_ / "rest.json", pose}, mesh_, images_, &log);
  ASSERT_EQ(picks.pixels.size(), 2u);
  EXPECT_EQ(picks.pixels[1].point.vertices, mesh_.faces.row(3).transpose());
  EXPECT_EQ(picks.pixels[1].point.weights, Eigen::Vector3d(0.2, 0.3, 0.5));
  EXPECT_THAT(picks.unpaired, ElementsAre("tail"));
  EXPECT_TRUE(log.warnings.empty());
  const fs::path strangers =
      Put("s.json", R"({"pixels": [{"name": "tail", "image": "b.jpg", "pixel": [3, 4]}]})");
  EXPECT_THROW(ReadPosePicks({folder_ / "rest.json", strangers}, mesh_, images_, &log), InputError);
  EXPECT_THROW(ReadPosePicks({pose, pose, pose}, mesh_, images_, &log), InputError);
}

TEST_F(PosePicksFile, LandmarksOfAScanOfThePoseAreLeftOutWithAWarning) {
  const fs::path rest = folder_ / "rest.json", scan = folder_ / "scan.json";
  WriteLandmarks(rest, mesh_, {{"ear", 3, {0.2, 0.3, 0.5}}});
  const Mesh scanned = MakeIcosphere(2);
  WriteLandmarks(scan, scanned, {{"ear", 5, {1, 0, 0}}});
  CarryLog log;
  const PosePicks none = ReadPosePicks({rest, scan}, mesh_, images_, &log);
  EXPECT_TRUE(none.places.empty()) << "its positions are in the frame of the scan";
  ASSERT_EQ(log.warnings.size(), 1u);
  EXPECT_THAT(log.warnings[0], HasSubstr("scan.json: its landmarks were picked on a mesh"));
  // The pose became one of few photographs, and was picked in them.
  std::string both = ReadFile(scan);
  both.insert(both.find('{') + 1,
              R"("pixels": [{"name": "ear", "image": "a.jpg", "pixel": [1, 2]}],)");
  const PosePicks picks = ReadPosePicks({rest, Put("both.json", both)}, mesh_, images_, &log);
  EXPECT_EQ(picks.pixels.size(), 1u);
  EXPECT_TRUE(picks.places.empty());
  const fs::path points = Put("p.pp", PickedPointsText({{"ear", 5, {1, 0, 0}}}, scanned));
  log = {};
  EXPECT_TRUE(ReadPosePicks({rest, points}, mesh_, images_, &log).pixels.empty());
  EXPECT_EQ(log.warnings.size(), 1u);
}

TEST_F(PosePicksFile, OfAPhotographThatWasShotAgainOrIsGoneAreLeftOut) {
  images_.folder = folder_;
  Put("a.jpg", "as it was");
  Put("b.jpg", "as it was");
  const std::string then = Sha256Of("as it was");
  const auto entry = [&](const std::string& image, int x) {
    return R"({"name": "ear", "vertex": 7, "image": ")" + image + R"(", "pixel": [)" +
           std::to_string(x) + R"(, 2], "photograph": ")" + then + "\"}";
  };
  const std::string text = "{\"pixels\": [" + entry("a.jpg", 1) + "," + entry("b.jpg", 2) + "," +
                           entry("c.jpg", 3) + "]}";
  PosePicks picks = Read(text);
  EXPECT_EQ(picks.pixels.size(), 2u);
  EXPECT_TRUE(picks.of_another.empty());
  EXPECT_THAT(picks.of_none, ElementsAre("'ear' in c.jpg"));
  Put("a.jpg", "shot again");
  images_.images[0].width = 1;  // the old pixel may lie outside of the new photograph
  images_.images[0].height = 1;
  picks = Read(text);
  ASSERT_EQ(picks.pixels.size(), 1u);
  EXPECT_EQ(picks.pixels[0].image, 1);
  EXPECT_THAT(picks.of_another, ElementsAre("'ear' in a.jpg"));
  Put("b.jpg", "shot again");
  EXPECT_TRUE(Read(text).pixels.empty()) << "none is left, which is no fault of the file";
  EXPECT_THAT(Fault(R"([{"name": "ear", "vertex": 7, "image": "a.jpg", "photograph": 3}])"),
              HasSubstr("pick 'ear' has a 'photograph' that is no text"));
}

TEST_F(PosePicksFile, FaultsNameThePickAndThePhotograph) {
  const std::string ear = R"({"name": "ear", "vertex": 7, "image": )";
  EXPECT_THAT(Fault("[" + ear + R"("c.jpg", "pixel": [1, 2]}])"),
              HasSubstr("pick 'ear' is in photograph 'c.jpg', which is not among the pose's 2: "
                        "a.jpg, b.jpg"));
  EXPECT_THAT(Fault("[" + ear + R"("a.jpg", "pixel": [641, 2]}])"),
              HasSubstr("pick 'ear' has pixel [641, 2], but photograph a.jpg has 640 x 480"));
  EXPECT_THAT(Fault("[" + ear + R"("a.jpg", "pixel": [1]}])"), HasSubstr("a list of 2 numbers"));
  const std::string good = ear + R"("a.jpg", "pixel": [1, 2]})";
  EXPECT_THAT(Fault("[" + good + "," + good + "]"), HasSubstr("twice in photograph a.jpg"));
  EXPECT_THAT(Fault(R"([{"name": "ear", "image": "a.jpg", "pixel": [1, 2], "face": 80,
                         "barycentric": [1, 0, 0]}])"),
              HasSubstr("pick 'ear' has face 80, but the template has 80 faces"));
  EXPECT_THAT(Fault(R"([{"name": "ear", "image": "a.jpg", "pixel": [1, 2]}])"),
              HasSubstr("needs its place on the template"));
  EXPECT_THAT(Fault(R"([{"image": "a.jpg"}])"), HasSubstr("pick 1 needs a 'name'"));
  EXPECT_THAT(Fault("[]"), HasSubstr("holds no pick"));
  EXPECT_THAT(Fault("7"), HasSubstr("a list 'pixels'"));
  EXPECT_THAT(FaultOf("{\"pixels\": ["), HasSubstr("is not JSON"));
  EXPECT_THAT(FaultOf(R"({"pairs": []})"), HasSubstr("a list 'pixels'"));
}

}  // namespace keypose::fit::pose_picks_test
