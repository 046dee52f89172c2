// What a run shows at its end, and its forecast at the start; with disk, clock and processes in
// memory.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/values/errors.h"
#include "pipeline/testing/fake_house.h"
#include "pipeline/testing/message_of.h"

namespace keypose::pipeline::ending_test {

using ::testing::HasSubstr;
using Names = std::vector<std::string>;

/// Makes a stage of the fake house write these fields to its report.
void Say(FakeHouse* house, const std::string& stage, const nlohmann::json& report) {
  auto& run = house->processes.stages["/bin/keypose-" + stage].run;
  run = [good = run, report](const FakeCall& call, MemoryDisk& d) {
    const int code = good(call, d);
    d.Write(call.Flag("report"), report.dump());
    return code;
  };
}

TEST(Ending, EndGathersWhatStagesSaidOncePerSentence) {
  FakeHouse house;
  Say(&house, "shoot", {{"warnings", {"dark", "dark", "blurred"}}});
  Say(&house, "match", {{"warnings", {"two landmarks look swapped"}}});
  Say(&house, "blend", {{"warnings", {"one frame is folded"}}});
  const auto verdict = [](const char* about, const char* grade) {
    return nlohmann::json{{"about", about}, {"grade", grade}, {"why", "w"}};
  };
  Say(&house, "tell", {{"verdicts", {verdict("bent", "wrong"), verdict("rest", "good")}}});
  const Ending ending = house.Run().ending;
  EXPECT_EQ(WarningsText(ending, 0),
            "4 warnings\n  rest, bent\n    shoot: dark\n    shoot: blurred\n  bent\n    match: two "
            "landmarks look swapped\n"
            "  all poses together\n    blend: one frame is folded\n");
  EXPECT_EQ(VerdictsText(ending, 0), "verdicts\n  rest  good   w\n  bent  wrong  w\n");
  EXPECT_EQ(WarningsText(house.Run().ending, 0), WarningsText(ending, 0))
      << "the same when all comes from the cache";
}

TEST(Ending, LinesOfTheEndFitTheTerminalAndPathsStayWhole) {
  Ending ending;
  ending.warnings.push_back(
      {{"shoot/rest"}, {"rest"}, "the seven photographs from the left are darker than the others"});
  ending.results.push_back(
      {"the animation", "/a/very/long/path/to/the/animation/of/a/character.glb", "blend"});
  EXPECT_EQ(WarningsText(ending, 40),
            "1 warning\n  rest\n    shoot: the seven photographs from\n           the left are "
            "darker than the\n           others\n");
  EXPECT_EQ(ResultsText(ending),
            "results\n  the animation  /a/very/long/path/to/the/animation/of/a/character.glb\n");
}

TEST(Ending, VerdictsOnATerminalHaveALineEachAndTheRestOnDemand) {
  Ending ending;
  ending.verdicts.push_back({"rest", "look", "the outlines lie half a pixel beside it", "tell"});
  ending.verdicts.push_back({"bent", "good", "it fits", "tell"});
  EXPECT_EQ(VerdictsText(ending, 30),
            "verdicts\n  rest  look  the outlines\u2026\n  bent  good  it fits\n"
            "  the whole of it: keypose status --details\n");
  EXPECT_EQ(VerdictsText(ending, 40, true),
            "verdicts\n  rest  look  the outlines lie half a\n              pixel beside it\n"
            "  bent  good  it fits\n");
}

TEST(Ending, ReportThatIsNoneTellsNothing) {
  FakeHouse house;
  for (const auto& report :
       {nlohmann::json(7), nlohmann::json{{"warnings", 7}, {"verdicts", {1, "a"}}},
        nlohmann::json{{"warnings", {1}}}}) {
    house.disk.Remove(house.project / ".keypose");
    Say(&house, "shape", report);
    EXPECT_TRUE(house.Run().ending.empty());
  }
}

TEST(Ending, EndOfAPartialRunTellsOfItsStepsOnly) {
  FakeHouse house;
  Say(&house, "shoot", {{"warnings", {"dark"}}});
  Say(&house, "match", {{"warnings", {"swapped"}}});
  house.Run();
  const Ending ending =
      house.Run({.from = {}, .until = {"shape/rest"}, .only = {}, .force = {}}).ending;
  ASSERT_EQ(ending.warnings.size(), 1u);
  EXPECT_EQ(ending.warnings[0].steps, (Names{"shoot/rest"}));
}

TEST(Ending, ResultsThatAPipelineShowsAreThoseThatExist) {
  FakeHouse house;
  house.WriteProject(
      "poses: {rest: photos/rest, bent: photos/bent}\n"
      "steps: {blend: {show: {animation/frame_0: the first frame, animation/none: nothing}}, tell: "
      "{show: {report/index.html: the "
      "report}}}\n");
  const Ending ending = house.Run().ending;
  ASSERT_EQ(ending.results.size(), 2u);
  EXPECT_EQ(ending.results[0].label, "the first frame");
  EXPECT_EQ(ending.results[1].path, house.project / "out/report/index.html");
  house.WriteProject(
      "poses: {rest: photos/rest}\nsteps: {tell: {show: {elsewhere/index.html: the report}}}\n");
  EXPECT_THAT(MessageOf<UsageError>([&] { house.Run(); }),
              HasSubstr("shows elsewhere/index.html, which is not among its results"));
}

TEST(Forecast, FirstRunIsForecastFromThePhotographs) {
  FakeHouse house;
  house.WriteProject(
      "poses: {rest: photos/rest, bent: photos/bent}\nsteps: {solve: {cost: {fixed: 10, "
      "photograph: 2}}, blend: {cost: {photograph: "
      "1}}}\n");
  const Forecast first = house.Run({}, {}, 4).forecast;
  EXPECT_EQ(first.cores, 4);
  // Three photographs; two poses side by side have two cores each.
  EXPECT_DOUBLE_EQ(first.steps.at("solve/rest").seconds, 16 / 2.0);
  EXPECT_EQ(first.steps.at("solve/rest").from, Expected::From::kCost);
  EXPECT_DOUBLE_EQ(first.steps.at("blend").seconds, 6 / 4.0)
      << "it goes back to the photographs of both poses";
  EXPECT_LT(first.steps.at("shape/rest").seconds, 0) << "nothing is known of it";
  house.WriteProject(
      "poses: {rest: photos/rest, bent: photos/bent}\nsteps: {solve: {cost: {fixed: "
      "10}}}\noptions: {solve: {depth: 10}}\n");
  EXPECT_EQ(house.Run().forecast.steps.at("solve/rest").from, Expected::From::kOwnRun)
      << "an earlier run tells more than a guess";
}

}  // namespace keypose::pipeline::ending_test
