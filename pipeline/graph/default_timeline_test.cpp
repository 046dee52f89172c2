// What plays where a project has no timeline, and the step that a single pose has too.
#include "pipeline/graph/default_timeline.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "core/io/text/files.h"
#include "core/testing/paths.h"
#include "core/values/errors.h"
#include "pipeline/testing/fake_house.h"
#include "pipeline/testing/message_of.h"

namespace keypose::pipeline::default_timeline_test {

using ::testing::HasSubstr;

const std::string kTwoPoses = "poses: {rest: photos/rest, bent: photos/bent}\n";

/// Whose default timeline holds for half a second and moves for three quarters.
struct LoopingHouse : FakeHouse {
  LoopingHouse() {
    default_pipeline +=
        "default_timeline: {hold: 0.5, move: 0.75, ease: in-out, unless: shape.depth}\n";
  }
};

bool HasTimeline(const FakeHouse& house) {
  return house.disk.Stat(house.project / "out/animation/timeline").has_value();
}

TEST(DefaultTimeline, IsALoopThatHoldsEachPoseAndEasesToTheNext) {
  LoopingHouse house;
  house.WriteProject(kTwoPoses + "fps: 12\n");
  house.Run();
  EXPECT_EQ(nlohmann::json::parse(house.Out("animation/timeline")),
            nlohmann::json::parse(R"({"schema": 2, "fps": 12, "loop": true, "keys": [
                {"pose": "rest", "time": 0, "hold": 0.5, "ease": "in-out"},
                {"pose": "bent", "time": 1.25, "hold": 0.5, "ease": "in-out"},
                {"pose": "rest", "time": 2.5}]})"));
  EXPECT_EQ(house.Out("animation/frame_2"), house.Out("animation/frame_0"))
      << "the last key is the first pose again";
  EXPECT_NE(house.Out("animation/frame_1"), house.Out("animation/frame_0"));
}

TEST(DefaultTimeline, GivesWayToAnOrderATimelineAndTheOptionThatItNames) {
  LoopingHouse house;
  house.WriteProject(kTwoPoses + "timeline: [bent, rest]\n");
  house.Run();
  EXPECT_FALSE(HasTimeline(house)) << "an order without times at 24 is the stage's own";
  house.WriteProject(kTwoPoses + "options: {shape: {depth: 5}}\n");
  house.Run();
  EXPECT_FALSE(HasTimeline(house));
  house.WriteProject(kTwoPoses);
  house.Run({}, {"shape.depth=5"});
  EXPECT_FALSE(HasTimeline(house));
  house.WriteProject(kTwoPoses + "timeline: [{pose: rest, at: 0}, {pose: bent, at: 3}]\n");
  house.Run();
  EXPECT_EQ(nlohmann::json::parse(house.Out("animation/timeline"))["keys"].size(), 2u);
}

TEST(DefaultTimeline, OfTheShippedPipelineLastsThreeSecondsForTwoPoses) {
  const auto shipped =
      ParsePipelineFile(ReadFile(SourceFolder() + "/pipeline.yaml"), "pipeline.yaml");
  std::vector<std::string> keys = {"rest", "bent"};
  PipelineFile file = shipped;
  const auto timeline = nlohmann::json::parse(TimelineUnlessSaid(file, {}, &keys));
  EXPECT_EQ(timeline["keys"][2]["time"], 3.0);
  EXPECT_EQ(timeline["keys"][1]["ease"], "in-out");
  EXPECT_EQ(keys, (std::vector<std::string>{"rest", "bent", "rest"}));
  keys = {"rest", "bent"};
  EXPECT_EQ(TimelineUnlessSaid(file, {{"interpolate", "", "steps", "5"}}, &keys), "");
  EXPECT_EQ(keys.size(), 2u);
  keys = {"rest"};
  EXPECT_EQ(TimelineUnlessSaid(file, {}, &keys), "") << "one pose has none";
}

TEST(DefaultTimeline, BadValuesAreRefusedWithTheirLine) {
  const auto fault = [](const std::string& yaml) {
    return MessageOf<UsageError>([&] { ParsePipelineFile("default_timeline: " + yaml, "p.yaml"); });
  };
  EXPECT_THAT(fault("{hold: -1}\n"), HasSubstr("p.yaml:1: hold must be from 0 to 3600 seconds"));
  EXPECT_THAT(fault("{move: 0}\n"), HasSubstr("move must be from 0.1 to 3600"));
  EXPECT_THAT(fault("{ease: soft}\n"), HasSubstr("ease must be linear, ease, in, out or in-out"));
  EXPECT_THAT(fault("{unless: steps}\n"), HasSubstr("unless must be STEP.OPTION"));
  EXPECT_THAT(fault("{holds: 1}\n"), HasSubstr("did you mean 'hold'?"));
}

TEST(StepOfTheCharacter, IsThereWithOnePoseTooAndTakesWhatThereIs) {
  FakeHouse house;
  house.default_pipeline.insert(house.default_pipeline.find("  tell:"),
                                "  show:\n    stage: solve\n    for: character\n    inputs: "
                                "{images: {either: [blend.frames, shoot.images]}}\n");
  house.WriteProject("poses: {rest: photos/rest}\n");
  const auto input_of_show = [&] {
    const FakeHouse::View view = house.Look();
    for (const Step& step : view.plan->graph().steps)
      if (step.id == "show") return step.inputs.at(0).flows.at(0).origin;
    return std::string();
  };
  EXPECT_EQ(input_of_show(), "shoot/rest.images");
  house.WriteProject(kTwoPoses);
  EXPECT_EQ(input_of_show(), "blend.frames");
}

}  // namespace keypose::pipeline::default_timeline_test
