// What a run refuses before its first step, instead of after an hour; and what of a timeline makes
// a step run again.
#include "pipeline/run/run_checks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/values/errors.h"
#include "pipeline/testing/fake_house.h"
#include "pipeline/testing/message_of.h"

namespace keypose::pipeline::run_checks_test {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

void Check(FakeHouse& house, const std::string& yaml, const Selection& selection = {}) {
  house.WriteProject(yaml);
  const FakeHouse::View view = house.Look(selection);
  RequireRunnable(*view.plan, ParsePipelineFile(yaml, "pipeline.yaml"), house.processes);
}

Selection Until(const std::string& step) {
  Selection selection;
  selection.until = {step};
  return selection;
}

std::string FaultOf(FakeHouse& house, const std::string& yaml) {
  return MessageOf<UsageError>([&] { Check(house, yaml); });
}

const std::string kPoses = "poses: {rest: photos/rest, bent: photos/bent}\n";

TEST(RunChecks, ALoopThatDoesNotCloseIsToldWithItsLine) {
  FakeHouse house;
  const std::string loop = kPoses + "timeline:\n  loop: true\n  keys:\n    - rest\n    - bent\n";
  EXPECT_THAT(FaultOf(house, loop),
              HasSubstr("pipeline.yaml:6: timeline: the timeline loops, but it begins with pose "
                        "'rest' and ends with 'bent'"));
  EXPECT_NO_THROW(Check(house, loop + "    - rest\n"));
  EXPECT_NO_THROW(Check(house, loop, Until("match"))) << "no step takes the timeline";
}

TEST(RunChecks, KeysInOneFrameAreToldWithTheirLine) {
  FakeHouse house;
  EXPECT_THAT(
      FaultOf(house, kPoses + "fps: 12\ntimeline:\n  - {pose: rest, at: 0}\n"
                              "  - {pose: bent, at: 0.04}\n"),
      AllOf(HasSubstr("pipeline.yaml:5: timeline: key 1 ('bent')"), HasSubstr("same frame")));
}

TEST(RunChecks, AnOwnTimelineHasItsKeysWhereTheFilmShowsThem) {
  FakeHouse house;
  house.disk.Write(house.project / "film.txt", "frames");
  const auto project = [](const std::string& keys) {
    return kPoses + "timeline: [" + keys +
           "]\nshot:\n  film: film.txt\n  shows: {0: rest, 4: bent}\n";
  };
  EXPECT_NO_THROW(
      Check(house, project("{pose: rest, at: 1}, {pose: bent, at: 1.3333, ease: in-out}")));
  EXPECT_NO_THROW(
      Check(house, project("{pose: rest, at: 0}, {pose: rest, at: 0.2}, {pose: bent, at: 0.333}")))
      << "more keys than filmed ones";
  EXPECT_NO_THROW(Check(house, project("rest, bent"))) << "the frames between keys may fit";
  EXPECT_THAT(
      FaultOf(house, project("{pose: rest, at: 1}, {pose: bent, at: 1.5}")),
      AllOf(HasSubstr("pipeline.yaml:5: the film shows 'bent' in frame 4, 0.333333 s after"),
            HasSubstr("give it {pose: bent, at: 1.33333}")));
  EXPECT_THAT(FaultOf(house, project("{pose: rest, at: 0}, {pose: rest, at: 0.3333}, "
                                     "{pose: bent, at: 1}")),
              HasSubstr("no key of it there"));
}

TEST(RunChecks, StagesAreAskedOnceForTheOptionsOfStepsThatMayRun) {
  FakeHouse house;
  Check(house, kPoses);
  EXPECT_THAT(house.processes.checked, IsEmpty()) << "defaults need no question";
  const std::string toned = kPoses + "options: {shoot: {tone: shrill}, shape: {depth: 3}}\n";
  Check(house, toned, Until("shoot"));
  EXPECT_THAT(house.processes.checked,
              ElementsAre(Names{"/bin/keypose-shoot", "--check_options", "--tone", "shrill"}));
  house.processes.stages.at("/bin/keypose-shape").refused =
      "keypose shape: error: depth goes in twos\n";
  EXPECT_EQ(FaultOf(house, toned), "options of step 'shape/rest': depth goes in twos");
  house.processes.stages.at("/bin/keypose-shape").refused =
      "keypose shape: error: The following arguments were not expected: --check_options\n";
  EXPECT_NO_THROW(Check(house, toned)) << "a stage of an older version";
  house.processes.stages.at("/bin/keypose-shape").refused = "";
  house.Run();
  house.processes.checked.clear();
  Check(house, toned);
  EXPECT_THAT(house.processes.checked, IsEmpty()) << "all is up to date";
}

TEST(TimelineOfAnOrder, HasTheProjectsRate) {
  FakeHouse house;
  house.WriteProject(kPoses);
  house.Run();
  EXPECT_FALSE(house.disk.Stat(house.project / "out/animation/timeline")) << "24 are a stage's own";
  for (const std::string order : {"", "timeline: [rest, bent]\n"}) {
    house.WriteProject(kPoses + order + "fps: 12\n");
    house.Run();
    EXPECT_EQ(nlohmann::json::parse(house.Out("animation/timeline")),
              nlohmann::json::parse(
                  R"({"schema": 2, "fps": 12, "keys": [{"pose": "rest"}, {"pose": "bent"}]})"));
  }
  house.WriteProject("poses: {rest: photos/rest}\nfps: 12\n");
  EXPECT_NO_THROW(house.Look()) << "one pose has no timeline";
}

TEST(Explain, NamesWhatChangedInTheTimeline) {
  FakeHouse house;
  const auto reasons = [&](const std::string& yaml) {
    house.WriteProject(kPoses + yaml);
    return house.Look().Reasons("blend");
  };
  house.WriteProject(kPoses +
                     "timeline: [{pose: rest, at: 0, hold: 0.5, step: 2}, {pose: bent, at: 1}]\n");
  house.Run();
  EXPECT_EQ(reasons("timeline:\n  - {pose: rest, at: 0, hold: 0.5, step: 2}   # calm\n  - {pose: "
                    "bent, at: 1}\n"),
            "");
  EXPECT_EQ(reasons("timeline: [{pose: rest, at: 0, hold: 0.5, step: 2}, {pose: bent, at: 1.5, "
                    "ease: in}]\nfps: 25\n"),
            "the timeline, fps: 24.0 -> 25.0\nthe timeline, key 1: {\"at\":1,\"pose\":\"bent\"} -> "
            "{\"at\":1.5,\"ease\":\"in\",\"pose\":\"bent\"}\n");
  EXPECT_EQ(reasons("timeline: {step: 2, keys: [{pose: rest, at: 0, hold: 0.5, step: 2}, {pose: "
                    "bent, at: 1}]}\n"),
            "the timeline, step is new: 2\n");
  EXPECT_EQ(reasons("timeline: [{pose: rest, at: 0, step: 2, hold: 0.5}, {pose: bent, at: 1}]\n"),
            "the timeline says the same in another order or spelling\n");
}

}  // namespace keypose::pipeline::run_checks_test
