// Picks, painted stiffness and regions are carried over when the mesh is made anew, or are refused
// by name. Tested with the commands that users type.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "core/io/meshes/mesh_io.h"
#include "core/io/project/landmarks_io.h"
#include "core/io/project/regions_io.h"
#include "core/io/text/files.h"
#include "core/numbers/kd_tree.h"
#include "core/surfaces/geometry.h"
#include "core/testing/folder.h"
#include "tests/run_program.h"

namespace keypose::tests::picks_follow_test {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr int kOk = 0, kUsage = 2, kInput = 3;

/// A character, and a new mesh of it with other vertices, rotated and scaled. `wrong` is another
/// figure.
class PicksFollow : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    world_ = std::make_unique<TestingFolder>();
    const auto pair = [&](const std::string& folder, const std::vector<std::string>& more) {
      std::vector<std::string> command = {"keypose-synth", "pair", folder,    "--vertices", "2500",
                                          "--ratio",       "1",    "--noise", "0"};
      command.insert(command.end(), more.begin(), more.end());
      const RunResult made = RunProgram(command, world_->path());
      ASSERT_EQ(made.exit_code, kOk) << made.output;
    };
    pair("clay", {"--shape", "character", "--seed", "3", "--bend", "0", "--turn", "40", "--scale",
                  "1.2", "--landmarks", "8"});
    pair("wrong", {"--shape", "tentacle", "--bend", "200", "--landmarks", "4"});
  }
  static void TearDownTestSuite() { world_.reset(); }

  static fs::path World(const std::string& name) { return world_->path() / name; }
  const fs::path& here() const { return folder_.path(); }
  RunResult Keypose(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), "keypose");
    return RunProgram(arguments, here());
  }
  nlohmann::json Read(const std::string& name) const {
    return nlohmann::json::parse(ReadFile(here() / name));
  }

  const fs::path before_ = World("clay/source.ply"), now_ = World("clay/target.ply");
  const fs::path picks_before_ = World("clay/source_landmarks.json"),
                 picks_now_ = World("clay/target_landmarks.json");

 private:
  static std::unique_ptr<TestingFolder> world_;
  TestingFolder folder_;
};
std::unique_ptr<TestingFolder> PicksFollow::world_;

TEST_F(PicksFollow, RegisterTakesThePicksToTheSameClay) {
  const Mesh before = ReadMesh(before_), now = ReadMesh(now_);
  const RunResult run =
      Keypose({"register", "--source", now_, "--target", now_, "--landmarks", picks_before_,
               "--landmarks", picks_now_, "--registered", "out.ply", "--report", "r.json"});
  ASSERT_EQ(run.exit_code, kOk) << run.output;
  EXPECT_THAT(run.output, AllOf(HasSubstr("8 picks were carried over"), HasSubstr("turned by")));
  // Source and target are the same mesh, so a correctly carried pick has no residual.
  EXPECT_LT(Read("r.json")["measurements"]["landmark_max_over_diag"].get<double>(), 0.01);
  // Without carrying over, the same face numbers give other places.
  const auto then = ReadLandmarks(picks_before_, before), truth = ReadLandmarks(picks_now_, now);
  double by_number = 0;
  for (std::size_t i = 0; i < then.size(); ++i) {
    Landmark same_number = then[i];
    same_number.face %= now.face_count();
    by_number =
        std::max(by_number, (PositionOf(same_number, now) - PositionOf(truth[i], now)).norm());
  }
  EXPECT_GT(by_number, 0.1 * BoundingDiagonal(now.points));
}

TEST_F(PicksFollow, BindCarriesThemAndWritesThemForTheNewMesh) {
  const RunResult run = Keypose(
      {"landmarks", "bind", "--mesh", now_, "--picks", picks_before_, "--bound", "bound.json"});
  ASSERT_EQ(run.exit_code, kOk) << run.output;
  const Mesh now = ReadMesh(now_);
  CarryLog log;
  const auto carried = ReadLandmarks(here() / "bound.json", now, &log),
             truth = ReadLandmarks(picks_now_, now);
  EXPECT_TRUE(log.notes.empty() && log.warnings.empty()) << "bound to this very mesh";
  ASSERT_EQ(carried.size(), truth.size());
  for (std::size_t i = 0; i < truth.size(); ++i)
    EXPECT_LT((PositionOf(carried[i], now) - PositionOf(truth[i], now)).norm(),
              0.008 * BoundingDiagonal(now.points))
        << truth[i].name;
}

TEST_F(PicksFollow, PicksOfAnotherThingAreRefusedByName) {
  const std::string name = ReadLandmarks(picks_before_, ReadMesh(before_))[0].name;
  const RunResult run =
      Keypose({"register", "--source", World("wrong/source.ply"), "--target", now_, "--landmarks",
               picks_before_, "--landmarks", picks_now_, "--registered", "out.ply"});
  EXPECT_EQ(run.exit_code, kInput) << run.output;
  EXPECT_THAT(run.output, AllOf(HasSubstr("source_landmarks.json"), HasSubstr("could not follow"),
                                HasSubstr("'" + name + "'"), HasSubstr("pick them again")));
  EXPECT_FALSE(fs::exists(here() / "out.ply"));
}

TEST_F(PicksFollow, OlderFilesAreBoundByACommand) {
  const Mesh before = ReadMesh(before_);
  nlohmann::json old = nlohmann::json::parse(ReadFile(picks_before_));
  old["schema"] = 1;
  old["mesh"] = {{"vertices", before.vertex_count()}, {"faces", before.face_count()}};
  for (auto& pick : old["landmarks"])
    pick.erase("position"), pick.erase("normal"), pick.erase("color");
  WriteFile(here() / "old picks.json", old.dump());
  const RunResult run =
      Keypose({"register", "--source", before_, "--target", now_, "--landmarks", "old picks.json",
               "--landmarks", picks_now_, "--registered", "out.ply", "--report", "r.json"});
  ASSERT_EQ(run.exit_code, kOk) << run.output;
  EXPECT_THAT(
      Read("r.json")["warnings"].dump(),
      AllOf(HasSubstr("old picks.json does not say on which source"), HasSubstr("landmarks bind")));
  // Bound in place; the path has a space.
  ASSERT_EQ(Keypose({"landmarks", "bind", "--mesh", before_, "--picks", "old picks.json", "--bound",
                     "old picks.json"})
                .exit_code,
            kOk);
  EXPECT_EQ(Read("old picks.json")["schema"], 2);
  EXPECT_EQ(Keypose({"landmarks", "bind", "--mesh", World("wrong/source.ply"), "--picks",
                     "old picks.json", "--bound", "x.json"})
                .exit_code,
            kInput);
  EXPECT_EQ(Keypose({"landmarks", "bind", "--mesh", before_, "--bound", "x.json"}).exit_code,
            kUsage);
}

TEST_F(PicksFollow, SwappedNumbersThatNothingBindsAreRefused) {
  const Mesh before = ReadMesh(before_);
  nlohmann::json old = nlohmann::json::parse(ReadFile(picks_before_));
  old["mesh"] = {{"vertices", before.vertex_count()}, {"faces", before.face_count()}};
  // Face numbers as on another mesh: each limb's pick lies on the next limb.
  auto& picks = old["landmarks"];
  const nlohmann::json first = picks[0]["face"];
  for (std::size_t k = 0; k + 1 < picks.size(); ++k) picks[k]["face"] = picks[k + 1]["face"];
  picks.back()["face"] = first;
  WriteFile(here() / "old.json", old.dump());
  const RunResult run = Keypose({"register", "--source", before_, "--target", now_, "--landmarks",
                                 "old.json", "--landmarks", picks_now_, "--registered", "out.ply"});
  EXPECT_EQ(run.exit_code, kInput) << run.output;
  EXPECT_THAT(run.output, AllOf(HasSubstr("does not say on which"), HasSubstr("landmarks bind")));
}

TEST_F(PicksFollow, PaintedStiffnessStaysOnItsPart) {
  Mesh painted = ReadMesh(before_);
  const Mesh now = ReadMesh(now_), truth = ReadMesh(World("clay/truth.ply"));
  const double top = painted.points.col(2).maxCoeff(), low = painted.points.col(2).minCoeff();
  painted.colors = ColorsX3::Constant(painted.vertex_count(), 3, 0);
  for (Eigen::Index v = 0; v < painted.points.rows(); ++v)
    if (painted.points(v, 2) > 0.6 * top + 0.4 * low) painted.colors.row(v).setConstant(255);
  WriteMesh(here() / "painted.ply", painted);
  const RunResult run = Keypose(
      {"landmarks", "bind", "--mesh", now_, "--stiffness", "painted.ply", "--bound", "s.json"});
  ASSERT_EQ(run.exit_code, kOk) << run.output;
  EXPECT_THAT(run.output, HasSubstr("the stiffness was carried over"));
  const KdTree tree(truth.points);  // vertices of the painted mesh, at their true new places
  const auto lines = Read("s.json")["stiffness"];
  int wrong = 0;
  for (int v = 0; v < now.vertex_count(); ++v) {
    const std::string line = lines[v];
    const double factor = std::stod(line.substr(line.rfind(' ')));
    wrong += (factor > 1) != (painted.colors(tree.Nearest(now.points.row(v)).index, 0) > 0);
  }
  EXPECT_LT(wrong, 0.02 * now.vertex_count());  // at the border of the painted part
  WriteMesh(here() / "painted.ply", ReadMesh(World("wrong/source.ply")));
  EXPECT_EQ(Keypose({"register", "--source", now_, "--target", now_, "--stiffness", "painted.ply",
                     "--registered", "o.ply"})
                .exit_code,
            kInput);
}

TEST_F(PicksFollow, RegionsOfTheTimelineTakeTheVerticesAtTheirPlaces) {
  const Mesh before = ReadMesh(before_), now = ReadMesh(now_),
             truth = ReadMesh(World("clay/truth.ply"));
  const Eigen::Vector3d tip = PositionOf(ReadLandmarks(picks_before_, before)[0], before);
  TimelineRegion region{"hand", {}, Eigen::Vector3d::Zero(), 0};
  for (int v = 0; v < before.vertex_count(); ++v)
    if ((before.points.row(v).transpose() - tip).norm() < 0.08 * BoundingDiagonal(before.points))
      region.vertices.push_back(v);
  const nlohmann::json timeline = {{"schema", 2},
                                   {"fps", 4},
                                   {"keys", {{{"time", 0}}, {{"time", 1}}}},
                                   {"regions", {{{"name", "hand"}, {"vertices", region.vertices}}}},
                                   {"pins", {{{"region", "hand"}}}}};
  WriteFile(here() / "timeline.json", timeline.dump());
  ASSERT_EQ(Keypose({"landmarks", "bind", "--mesh", before_, "--timeline", "timeline.json",
                     "--bound", "regions.json"})
                .exit_code,
            kOk);
  const RunResult run =
      Keypose({"interpolate", "--keys", now_, "--keys", now_, "--timeline", "timeline.json",
               "--regions", "regions.json", "--frames", "frames"});
  ASSERT_EQ(run.exit_code, kOk) << run.output;
  EXPECT_THAT(run.output, HasSubstr("'hand' were carried over"));
  Timeline carried;
  carried.regions = {region};
  FollowRegions(here() / "regions.json", now, carried, nullptr);
  EXPECT_NEAR(static_cast<double>(carried.regions[0].vertices.size()),
              static_cast<double>(region.vertices.size()),
              0.25 * static_cast<double>(region.vertices.size()));
  Eigen::Vector3d center = Eigen::Vector3d::Zero(), expected = Eigen::Vector3d::Zero();
  for (const int v : carried.regions[0].vertices)
    center +=
        now.points.row(v).transpose() / static_cast<double>(carried.regions[0].vertices.size());
  for (const int v : region.vertices)
    expected += truth.points.row(v).transpose() / static_cast<double>(region.vertices.size());
  EXPECT_LT((center - expected).norm(), 0.01 * BoundingDiagonal(now.points));

  const RunResult unbound = Keypose({"interpolate", "--keys", before_, "--keys", before_,
                                     "--timeline", "timeline.json", "--frames", "f2"});
  EXPECT_EQ(unbound.exit_code, kOk) << unbound.output;
  EXPECT_THAT(unbound.output, AllOf(HasSubstr("region 'hand'"), HasSubstr("landmarks bind")));
  const fs::path wrong = World("wrong/source.ply");
  const RunResult lost = Keypose({"interpolate", "--keys", wrong, "--keys", wrong, "--timeline",
                                  "timeline.json", "--regions", "regions.json", "--frames", "f3"});
  EXPECT_EQ(lost.exit_code, kInput) << lost.output;
  EXPECT_THAT(lost.output, HasSubstr("'hand'"));
}

}  // namespace keypose::tests::picks_follow_test
