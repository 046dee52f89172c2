// The rebuild rules, with disk, clock and processes in memory.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/values/errors.h"
#include "pipeline/testing/fake_house.h"
#include "pipeline/testing/message_of.h"

namespace keypose::pipeline::rules_test {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

TEST(Rules, FirstRunMakesEveryStepOnceAndNamesItsResults) {
  FakeHouse house;
  const auto outcome = house.Run();
  EXPECT_EQ(outcome.result.code, ExitCode::kOk);
  EXPECT_EQ(outcome.ran, kAllSteps);
  EXPECT_EQ(house.Out("rest/mesh.txt"), "9(model 9rrr)");
  EXPECT_THAT(house.Out("animation/frame_1"), HasSubstr("(source 9(model"));
  EXPECT_THAT(house.Out("report/index.html"), HasSubstr("blend"));
}

TEST(Rules, SecondRunRunsNothingAndReadsNoFile) {
  FakeHouse house;
  house.Run();
  const int hashed = house.disk.hashed(), asked = house.processes.asked;
  EXPECT_THAT(house.Run().ran, IsEmpty());
  EXPECT_EQ(house.disk.hashed(), hashed);
  EXPECT_EQ(house.processes.asked, asked) << "stages were asked to describe themselves again";
}

TEST(Rules, TouchRunsNothing) {
  FakeHouse house;
  house.Run();
  house.disk.Touch(house.project / "photos/rest/IMG_1.jpg");
  EXPECT_THAT(house.Run().ran, IsEmpty());
}

TEST(Rules, OtherCoreCountRunsNothing) {
  FakeHouse house;
  house.Run({}, {}, 1);
  EXPECT_THAT(house.Run({}, {}, 8).ran, IsEmpty());
}

TEST(Rules, MovedProjectRunsNothingAndKeepsItsResults) {
  FakeHouse house;
  house.Run();
  house.MoveProject("/mnt/other/machine");
  const auto outcome = house.Run();
  EXPECT_THAT(outcome.ran, IsEmpty());
  EXPECT_THAT(outcome.notes, IsEmpty());
}

TEST(Rules, ChangedPhotographOfOnePoseRunsThatPoseOnly) {
  FakeHouse house;
  house.Run();
  house.disk.Write(house.project / "photos/bent/IMG_1.jpg", "Bpicture retaken");
  EXPECT_EQ(house.Look().Reasons("shoot/bent"), "photos/bent/IMG_1.jpg changed\n");
  const auto outcome = house.Run();
  EXPECT_EQ(outcome.ran,
            (Names{"blend", "match/bent", "shape/bent", "shoot/bent", "solve/bent", "tell"}));
}

TEST(Rules, EqualOutputCutsOffWhatFollows) {
  FakeHouse house;
  house.Run();
  // Another picture with the same first letters, which are all that `solve` depends on.
  house.disk.Write(house.project / "photos/bent/IMG_1.jpg", "b picture with a difference");
  EXPECT_EQ(house.Run().ran, (Names{"shoot/bent", "solve/bent", "tell"}));
}

TEST(Rules, AddedAndRemovedPhotographsAreNamed) {
  FakeHouse house;
  house.Run();
  house.disk.Write(house.project / "photos/rest/IMG_9.jpg", "r new");
  house.disk.Remove(house.project / "photos/rest/IMG_0.jpg");
  EXPECT_EQ(house.Look().Reasons("shoot/rest"),
            "photos/rest/IMG_0.jpg is gone\nphotos/rest/IMG_9.jpg is new\n");
}

TEST(Rules, FileManagersLitterDoesNotCount) {
  FakeHouse house;
  house.Run();
  house.disk.Write(house.project / "photos/rest/.DS_Store", "x");
  house.disk.Write(house.project / "photos/rest/Thumbs.db", "x");
  house.disk.Write(house.project / "photos/rest/@eaDir/1.jpg/SYNOPHOTO_THUMB_M.jpg", "x");
  EXPECT_THAT(house.Run().ran, IsEmpty());
}

TEST(Rules, OptionChangeRunsStepAndWhatDependsOnIt) {
  FakeHouse house;
  house.Run();
  house.WriteProject(
      "poses: {rest: photos/rest, bent: photos/bent}\noptions: {shape: {depth: 10}}\n");
  EXPECT_EQ(house.Look().Reasons("shape/rest"), "option depth: 9 -> 10\n");
  EXPECT_EQ(house.Run().ran, (Names{"blend", "match/bent", "shape/bent", "shape/rest", "tell"}));
}

TEST(Rules, OptionOfOnePoseRunsThatPoseOnly) {
  FakeHouse house;
  house.Run();
  house.WriteProject(
      "poses:\n  rest: photos/rest\n  bent: {photos: photos/bent, options: {shape: {depth: "
      "10}}}\n");
  EXPECT_EQ(house.Run().ran, (Names{"blend", "match/bent", "shape/bent", "tell"}));
}

TEST(Rules, DefaultMadeExplicitInAnySpellingRunsNothing) {
  FakeHouse house;
  house.Run();
  house.WriteProject(
      "poses: {rest: photos/rest, bent: photos/bent}\noptions: {shape: {depth: 9}, solve: {speed: "
      "5.0e-1}, shoot: {tone: plain}}\n");
  EXPECT_THAT(house.Run().ran, IsEmpty());
}

TEST(Rules, OptionSetBackIsTakenFromTheCache) {
  FakeHouse house;
  house.Run();
  EXPECT_THAT(house.Run({}, {"shape.depth=10"}).ran, SizeIs(5));
  const std::string changed = house.Out("rest/mesh.txt");
  EXPECT_THAT(house.Run().ran, IsEmpty());
  EXPECT_NE(house.Out("rest/mesh.txt"), changed) << "out/ must follow the cache";
}

TEST(Rules, SetOfOnePoseRunsThatPoseOnly) {
  FakeHouse house;
  house.Run();
  EXPECT_EQ(house.Run({}, {"shape/bent.depth=10"}).ran,
            (Names{"blend", "match/bent", "shape/bent", "tell"}));
}

TEST(Rules, StageVersionChangeRunsIt) {
  FakeHouse house;
  house.Run();
  house.processes.stages["/bin/keypose-match"].describe["version"] = "2";
  house.disk.Touch("/bin/keypose-match");
  EXPECT_EQ(house.Look().Reasons("match/bent"), "the stage's version: 1 -> 2\n");
  EXPECT_EQ(house.Run().ran, (Names{"match/bent", "tell"}))
      << "its output is as before, so only the report follows";
}

TEST(Rules, RebuiltStageOfTheSameVersionRunsNothing) {
  FakeHouse house;
  house.Run();
  house.disk.Touch("/bin/keypose-match");
  EXPECT_THAT(house.Run().ran, IsEmpty());
}

TEST(Rules, ToolVersionChangeRunsItsStage) {
  FakeHouse house;
  house.disk.Write("/usr/bin/colmap", "3.8");
  house.processes.tools["colmap"] = "/usr/bin/colmap";
  auto& describe = house.processes.stages["/bin/keypose-solve"].describe;
  describe["tools"] = nlohmann::json::array({{{"name", "colmap"}, {"version", "COLMAP 3.8"}}});
  house.Run();
  house.disk.Write("/usr/bin/colmap", "3.9 is larger");
  describe["tools"] = nlohmann::json::array({{{"name", "colmap"}, {"version", "COLMAP 3.9"}}});
  EXPECT_EQ(house.Look().Reasons("solve/rest"),
            "version of the tool colmap: COLMAP 3.8 -> COLMAP 3.9\n");
  // The models are the same, so only the report runs again, since it shows versions.
  EXPECT_EQ(house.Run().ran, (Names{"solve/bent", "solve/rest", "tell"}));
}

TEST(Rules, ForceRunsTheStepAgainAndCutsOffWhatFollows) {
  FakeHouse house;
  house.Run();
  EXPECT_EQ(house.Run({.from = {}, .until = {}, .only = {}, .force = {"solve/rest"}}).ran,
            (Names{"solve/rest"}));
  EXPECT_THAT(house.Run().ran, IsEmpty());
}

TEST(Rules, UntilRunsOnlyWhatIsNeeded) {
  FakeHouse house;
  EXPECT_EQ(house.Run({.from = {}, .until = {"shape/bent"}, .only = {}, .force = {}}).ran,
            (Names{"shape/bent", "shoot/bent", "solve/bent"}));
}

TEST(Rules, FromTakesWhatLiesBeforeAsItWasMade) {
  FakeHouse house;
  house.Run();
  house.disk.Write(house.project / "photos/bent/IMG_1.jpg", "Xchanged");
  house.WriteProject(
      "poses: {rest: photos/rest, bent: photos/bent}\noptions: {shape: {depth: 10}}\n");
  EXPECT_EQ(house.Run({.from = {"shape"}, .until = {"shape"}, .only = {}, .force = {}}).ran,
            (Names{"shape/bent", "shape/rest"}));
}

TEST(Rules, OnlyRunsJustThatAndNeedsWhatLiesBefore) {
  FakeHouse house;
  const Selection only{.from = {}, .until = {}, .only = {"shape/rest"}, .force = {}};
  EXPECT_THAT(MessageOf<UsageError>([&] { house.Run(only); }),
              HasSubstr("shape/rest needs solve/rest, which was not selected"));
  house.Run({.from = {}, .until = {"solve"}, .only = {}, .force = {}});
  EXPECT_EQ(house.Run(only).ran, (Names{"shape/rest"}));
}

TEST(Rules, SelectionOfUnknownStepNamesTheNearest) {
  FakeHouse house;
  EXPECT_THAT(MessageOf<UsageError>(
                  [&] { house.Run({.from = {}, .until = {"shap"}, .only = {}, .force = {}}); }),
              HasSubstr("did you mean 'shape'?"));
}

TEST(Rules, LookingRunsNothingAndChangesNothing) {
  FakeHouse house;
  house.Run();
  house.disk.Write(house.project / "photos/rest/IMG_1.jpg", "Xchanged");
  const auto before = house.disk.FilesBelow("/");
  const auto view = house.Look();
  EXPECT_EQ(view.Step("shoot/rest").state, StepPlan::State::kReady);
  EXPECT_EQ(view.Step("solve/rest").state, StepPlan::State::kWaiting);
  EXPECT_THAT(view.plan->WaitsFor(view.graph->Find("solve/rest").front()),
              ElementsAre("shoot/rest"));
  EXPECT_EQ(view.Step("shape/bent").state, StepPlan::State::kDone);
  EXPECT_EQ(house.disk.FilesBelow("/"), before);
}

TEST(Rules, DeletedResultComesBackWithoutARun) {
  FakeHouse house;
  house.Run();
  const std::string mesh = house.Out("bent/mesh.txt");
  house.disk.Remove(house.project / "out/bent");
  EXPECT_THAT(house.Run().ran, IsEmpty());
  EXPECT_EQ(house.Out("bent/mesh.txt"), mesh);
}

TEST(Rules, ResultEditedByHandIsKeptBesideTheRestoredOne) {
  FakeHouse house;
  house.Run();
  const std::string mesh = house.Out("bent/mesh.txt");
  house.disk.Write(house.project / "out/bent/mesh.txt", "sculpted by hand");
  const auto outcome = house.Run();
  EXPECT_THAT(outcome.ran, IsEmpty());
  EXPECT_EQ(house.Out("bent/mesh.txt"), mesh);
  EXPECT_EQ(house.Out("bent/mesh.txt.mine"), "sculpted by hand");
  EXPECT_THAT(outcome.notes, ElementsAre(HasSubstr("changed by hand")));
}

TEST(Rules, ResultsOfARemovedPoseGo) {
  FakeHouse house;
  house.Run();
  house.WriteProject("poses: {rest: photos/rest}\n");
  EXPECT_EQ(house.Run().ran, (Names{"tell"}));
  EXPECT_FALSE(house.disk.Stat(house.project / "out/bent"));
  EXPECT_FALSE(house.disk.Stat(house.project / "out/animation"));
  EXPECT_TRUE(house.disk.Stat(house.project / "out/rest/mesh.txt"));
}

TEST(Rules, OnePoseEndsInItsReportWithoutAnAnimation) {
  FakeHouse house;
  house.WriteProject("poses: {rest: photos/rest}\n");
  EXPECT_EQ(house.Run().ran, (Names{"shape/rest", "shoot/rest", "solve/rest", "tell"}));
}

TEST(Rules, PosesWithEqualPhotographsShareArtifacts) {
  FakeHouse house;
  for (int i = 0; i < 3; ++i) {
    const std::string name = "IMG_" + std::to_string(i) + ".jpg";
    house.disk.Write(house.project / "photos/bent" / name,
                     house.disk.Read(house.project / "photos/rest" / name));
  }
  EXPECT_EQ(house.Run().ran,
            (Names{"blend", "match/bent", "shape/rest", "shoot/rest", "solve/rest", "tell"}));
}

TEST(Rules, IndependentStepsRunSideBySideAndShareTheCores) {
  FakeHouse house;
  house.Run({}, {}, 2);
  EXPECT_EQ(house.processes.most_at_once, 2);
  EXPECT_EQ(house.processes.calls[0].environment.at("KEYPOSE_THREADS"), "1");
  EXPECT_EQ(house.processes.calls.back().environment.at("KEYPOSE_THREADS"), "2")
      << "a step that is alone gets all cores";
}

TEST(Rules, OneCoreRunsOneAtATime) {
  FakeHouse house;
  house.Run({}, {}, 1);
  EXPECT_EQ(house.processes.most_at_once, 1);
}

TEST(Rules, LandmarksOfBothPosesAreTakenUpWhenTheyAppear) {
  FakeHouse house;
  house.Run();
  house.disk.Write(house.project / "landmarks/rest.json", "rest picks");
  const auto alone = house.Run();
  EXPECT_THAT(alone.ran, IsEmpty()) << "one file alone makes no pairs";
  EXPECT_THAT(alone.notes, ElementsAre(AllOf(HasSubstr("landmarks/rest.json is not used"),
                                             HasSubstr("landmarks/bent.json or .pp"))));
  house.disk.Write(house.project / "landmarks/bent.json", "bent picks");
  EXPECT_THAT(house.Look().Reasons("match/bent"),
              HasSubstr("input landmarks now also gets landmarks/rest.json"));
  EXPECT_EQ(house.Run().ran, (Names{"blend", "match/bent", "tell"}));
  EXPECT_THAT(house.Out("animation/frame_1"), HasSubstr("(landmarks rest picks bent picks)"));
}

TEST(Rules, APaintedStiffnessIsTakenUpWhenItAppearsAndLeftOutWhenItIsGone) {
  FakeHouse house;
  house.Run();
  house.disk.Write(house.project / "stiffness.json", "stiff hand");
  EXPECT_EQ(house.Run().ran, (Names{"blend", "match/bent", "tell"}));
  EXPECT_THAT(house.Out("animation/frame_1"), HasSubstr("(stiffness stiff hand)"));
  house.disk.Remove(house.project / "stiffness.json");
  EXPECT_THAT(house.Run().ran, IsEmpty()) << "the earlier result is in the cache";
  EXPECT_THAT(house.Out("animation/frame_1"), Not(HasSubstr("stiffness")));
}

TEST(Rules, PickedPointsOfMeshLabAreTakenUpWhereNoJsonIs) {
  FakeHouse house;
  house.disk.Write(house.project / "landmarks/rest.pp", "rest points");
  house.disk.Write(house.project / "landmarks/bent.pp", "bent points");
  EXPECT_THAT(house.Run().notes, IsEmpty());
  EXPECT_THAT(house.Out("animation/frame_1"), HasSubstr("(landmarks rest points bent points)"));
  house.disk.Write(house.project / "landmarks/bent.json", "bent picks");
  EXPECT_THAT(house.Run().notes,
              ElementsAre(HasSubstr(
                  "landmarks/bent.pp is not used, because landmarks/bent.json is there too")));
  EXPECT_THAT(house.Out("animation/frame_1"), HasSubstr("(landmarks rest points bent picks)"));
}

TEST(Rules, TimelineOrdersAndRepeatsTheKeysAndIsHandedOn) {
  FakeHouse house;
  house.WriteProject(
      "poses: {rest: photos/rest, bent: photos/bent}\nfps: 30\n"
      "timeline: [{pose: rest, at: 0}, {pose: bent, at: 0.5}, {pose: rest, at: 2}]\n");
  house.Run();
  const auto timeline = nlohmann::json::parse(house.Out("animation/timeline"));
  EXPECT_EQ(timeline["fps"], 30);
  ASSERT_EQ(timeline["keys"].size(), 3u);
  EXPECT_EQ(timeline["keys"][1]["pose"], "bent");
  EXPECT_EQ(timeline["keys"][2]["time"], 2.0);
  EXPECT_EQ(house.Out("animation/frame_0"), house.Out("rest/mesh.txt"));
  EXPECT_THAT(house.Out("animation/frame_1"), HasSubstr("(target"));
  EXPECT_EQ(house.Out("animation/frame_2"), house.Out("rest/mesh.txt"));
}

TEST(Rules, TimelineWithoutTimesOnlyOrdersTheKeys) {
  FakeHouse house;
  house.WriteProject("poses: {rest: photos/rest, bent: photos/bent}\ntimeline: [bent, rest]\n");
  house.Run();
  EXPECT_FALSE(house.disk.Stat(house.project / "out/animation/timeline"));
  EXPECT_EQ(house.Out("animation/frame_1"), house.Out("rest/mesh.txt"));
}

TEST(Rules, EverythingThatATimelineSaysReachesTheStage) {
  FakeHouse house;
  house.WriteProject(
      "poses: {rest: photos/rest, 'bent': photos/bent}\nfps: 12\n"
      "timeline:\n  loop: true\n  step: 2\n  table: -0.5\n  regions: [{name: '7', center: [0, 0.5, "
      "1e-1], radius: 2}]\n"
      "  pins: [{region: 7}]\n"
      "  keys:\n    - {pose: rest, at: 0, hold: 0.5, ease: [0.4, 0, 1, 1]}\n    - {pose: bent, at: "
      "1, interpolation: stepped, turns: {7: "
      "1}}\n"
      "    - {pose: rest, at: 2}\n");
  house.Run();
  const auto timeline = nlohmann::json::parse(house.Out("animation/timeline"));
  EXPECT_EQ(timeline, nlohmann::json::parse(
                          R"({"schema": 2, "fps": 12.0, "loop": true, "step": 2, "table": -0.5,
      "regions": [{"name": "7", "center": [0, 0.5, 0.1], "radius": 2}], "pins": [{"region": "7"}],
      "keys": [{"pose": "rest", "time": 0, "hold": 0.5, "ease": [0.4, 0, 1, 1]},
               {"pose": "bent", "time": 1, "interpolation": "stepped", "turns": {"7": 1}}, {"pose": "rest", "time": 2}]})"));
  EXPECT_EQ(house.Out("animation/frame_2"), house.Out("rest/mesh.txt"));
}

TEST(Rules, KeysWithoutTimesMayStillHold) {
  FakeHouse house;
  house.WriteProject(
      "poses: {rest: photos/rest, bent: photos/bent}\ntimeline: [{pose: bent, hold: 1}, rest]\n");
  house.Run();
  EXPECT_EQ(nlohmann::json::parse(house.Out("animation/timeline"))["keys"][0]["hold"], 1);
}

TEST(Rules, FramesPerSecondReachAnOptionThatNamesThem) {
  FakeHouse house;
  house.WriteProject(
      "poses: {rest: photos/rest}\nfps: 12\nsteps: {shape: {options: {depth: $fps}}}\n");
  EXPECT_EQ(house.Look().Step("shoot/rest").state, StepPlan::State::kReady);
  house.Run();
  EXPECT_EQ(house.Out("rest/mesh.txt"), "12(model 9rrr)");
}

TEST(Rules, PosesOfTheKeysReachAnOptionThatNamesThem) {
  FakeHouse house;
  house.Run();
  house.WriteProject(
      "poses: {rest: photos/rest, bent: photos/bent}\ntimeline: [rest, bent, rest]\nsteps: {shoot: "
      "{options: {tone: $keys}}}\n");
  EXPECT_THAT(house.Look().Reasons("shoot/rest"), HasSubstr("rest,bent,rest"));
}

TEST(Rules, TemplateChangeRunsThePairTheOtherWayRound) {
  FakeHouse house;
  house.Run();
  house.WriteProject("poses: {rest: photos/rest, bent: photos/bent}\ntemplate: bent\n");
  EXPECT_EQ(house.Run().ran, (Names{"blend", "match/rest", "tell"}));
}

TEST(Rules, OwnProgramJoinsAndReplacesAStage) {
  FakeHouse house;
  house.Run();
  house.disk.Write(house.project / "tools/polish", "program");
  auto own = house.processes.stages["/bin/keypose-shape"];
  own.describe["stage"] = "polish";
  own.run = [](const FakeCall& call, MemoryDisk& d) {
    d.Write(call.Flag("mesh"), "polished");
    return 0;
  };
  house.processes.stages[(house.project / "tools/polish").string()] = own;
  house.WriteProject(
      "poses: {rest: photos/rest, bent: photos/bent}\nsteps: {shape: {program: tools/polish}}\n");
  EXPECT_EQ(house.Look().Reasons("shape/rest"), "the stage is another: shape -> polish\n");
  EXPECT_EQ(house.Run().ran, (Names{"blend", "match/bent", "shape/bent", "shape/rest", "tell"}));
  EXPECT_EQ(house.Out("rest/mesh.txt"), "polished");
}

TEST(Rules, OwnStepCanBeAdded) {
  FakeHouse house;
  house.Run();
  house.WriteProject(
      "poses: {rest: photos/rest, bent: photos/bent}\n"
      "steps:\n  deeper: {stage: solve, for: pose, inputs: {images: shoot.images}, options: "
      "{depth: 12}, out: {model: "
      "'deep/{pose}.txt'}}\n");
  EXPECT_EQ(house.Run().ran, (Names{"deeper/bent", "deeper/rest", "tell"}));
  EXPECT_EQ(house.Out("deep/rest.txt"), "12rrr");
}

TEST(Rules, EstimateOfTheNextRunComesFromTheLast) {
  FakeHouse house;
  house.processes.stages["/bin/keypose-solve"].seconds = 42;
  house.Run();
  EXPECT_DOUBLE_EQ(house.Look().Step("solve/rest").last->seconds, 42);
}

TEST(Rules, PathPortTakesAFileOrAFolderOfTheProject) {
  FakeHouse house;
  auto& solve = house.processes.stages["/bin/keypose-solve"];
  solve.describe["inputs"].push_back({{"name", "poses"}, {"kind", "path"}, {"optional", true}});
  const auto given = [&] {
    for (const FakeCall& call : house.processes.calls) {
      if (call.program == "/bin/keypose-solve" &&
          call.Flag("model").find("solve.rest") != std::string::npos)
        return call.Flag("poses");
    }
    return std::string("none");
  };
  house.default_pipeline.replace(house.default_pipeline.find("{images: shoot.images}"), 22,
                                 "{images: shoot.images, poses: $cameras}");
  house.disk.Write(house.project / "cameras/rest/cameras.bin", "c");
  house.disk.Write(house.project / "cameras/rest/images.bin", "i");
  house.WriteProject(
      "poses: {rest: {photos: photos/rest, cameras: cameras/rest}, bent: photos/bent}\n");
  EXPECT_EQ(house.Run().result.code, ExitCode::kOk);
  EXPECT_EQ(given(), (house.project / "cameras/rest").string());
  house.disk.Write(house.project / "cameras/rest/images.bin", "other");
  EXPECT_EQ(house.Look().Reasons("solve/rest"), "cameras/rest/images.bin changed\n");
  house.disk.Write(house.project / "cameras/rest.json", "{}");
  house.WriteProject(
      "poses: {rest: {photos: photos/rest, cameras: cameras/rest.json}, bent: photos/bent}\n");
  house.processes.calls.clear();
  EXPECT_EQ(house.Run().result.code, ExitCode::kOk);
  EXPECT_EQ(given(), (house.project / "cameras/rest.json").string());
}

TEST(Rules, MemoryLimitKeepsLargeStepsApart) {
  FakeHouse house;
  for (auto& [program, stage] : house.processes.stages)
    stage.describe["resources"]["memory_bytes"] = 800;
  auto view = house.Look();
  ContentHasher hasher(house.disk, house.project / ".keypose/hashes.json", house.project);
  ArtifactStore store(house.disk, house.project / ".keypose");
  Records records(house.disk, house.project / ".keypose");
  Workshop workshop{house.disk, hasher, store, records, house.project};
  Plan plan(*view.graph, workshop, {});
  ResultsFolder results(house.disk, house.project / "out", house.project / ".keypose/out.json");
  class Silent final : public RunObserver {
    void Begin(const Forecast&) override {}
    void Started(const std::string&, const std::vector<std::string>&, int) override {}
    void Progressed(const std::string&, double, const std::string&) override {}
    void Finished(const std::string&, const std::string&, double) override {}
    void Note(const std::string&) override {}
  } silent;
  RunRecord record;
  record.name = "run";
  EXPECT_EQ(Builder(plan, workshop, house.processes, house.clock, results, silent, {8, 1500})
                .Run(record)
                .code,
            ExitCode::kOk);
  EXPECT_EQ(house.processes.most_at_once, 1);
}

}  // namespace keypose::pipeline::rules_test
