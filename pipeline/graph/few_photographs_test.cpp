// Poses from few photographs (`method: fit`): which steps they have, what flows into them, what
// makes them run.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/values/errors.h"
#include "pipeline/testing/fake_house.h"
#include "pipeline/testing/message_of.h"

namespace keypose::pipeline::few_photographs_test {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// The fake house's pipeline with a step for poses of few photographs.
const char* const kWithBend = R"(steps:
  shoot: {stage: shoot, for: pose, inputs: {photos: $photos}}
  solve: {stage: solve, for: pose, method: scan, inputs: {images: shoot.images}}
  shape:
    stage: shape
    for: pose
    method: scan
    inputs: {model: solve.model}
    out: {mesh: "{pose}/mesh.txt"}
  match:
    stage: match
    for: pair
    method: scan
    inputs: {source: shape.mesh@template, target: shape.mesh, landmarks: $landmarks, stiffness: $stiffness}
  bend:
    stage: bend
    for: pair
    method: fit
    inputs: {template: shape.mesh@template, images: shoot.images, rig: solve.model@template}
    out: {bent: "{pose}/mesh.txt"}
  blend:
    stage: blend
    for: animation
    inputs: {keys: {template: shape.mesh, others: match.matched, fit: bend.bent}, timeline: $timeline}
    out: {frames: animation}
  tell:
    stage: tell
    for: project
    inputs: {run: $run}
    out: {report_page: report}
)";

struct FewHouse : FakeHouse {
  FewHouse() {
    default_pipeline = kWithBend;
    WriteProject(
        "poses:\n  rest: photos/rest\n  bent: photos/bent\n  wave: {photos: photos/wave, "
        "method: fit}\ntimeline: [rest, wave, bent]\n");
    for (const char* name : {"IMG_0.jpg", "IMG_1.jpg"})
      disk.Write(project / "photos/wave" / name, "w picture");
  }
};

TEST(FewPhotographs, PoseHasTheStepsThatFitItAndNoneThatScan) {
  FewHouse house;
  const auto outcome = house.Run();
  EXPECT_EQ(outcome.result.code, ExitCode::kOk);
  EXPECT_EQ(outcome.ran,
            (Names{"bend/wave", "blend", "match/bent", "shape/bent", "shape/rest", "shoot/bent",
                   "shoot/rest", "shoot/wave", "solve/bent", "solve/rest", "tell"}));
  EXPECT_THAT(house.Out("wave/mesh.txt"),
              AllOf(HasSubstr("(template 9(model"), HasSubstr("(images IMG_0.jpg=w picture"),
                    HasSubstr("(rig 9rrr)")));
}

TEST(FewPhotographs, TimelineTakesTheFittedMeshWhereTheRegisteredOneStands) {
  FewHouse house;
  house.Run();
  EXPECT_THAT(house.Out("animation/frame_1"), HasSubstr("w picture")) << "wave is the second key";
  EXPECT_THAT(house.Out("animation/frame_2"), HasSubstr("(source ")) << "bent is matched";
}

TEST(FewPhotographs, RetakenPhotographRunsTheFitAndWhatFollows) {
  FewHouse house;
  house.Run();
  house.disk.Write(house.project / "photos/wave/IMG_1.jpg", "w retaken");
  EXPECT_EQ(house.Look().Reasons("shoot/wave"), "photos/wave/IMG_1.jpg changed\n");
  EXPECT_EQ(house.Run().ran, (Names{"bend/wave", "blend", "shoot/wave", "tell"}));
}

TEST(FewPhotographs, MorePhotographsNeverFlipTheMethod) {
  FewHouse house;
  house.Run();
  for (int i = 2; i < 40; ++i)
    house.disk.Write(house.project / "photos/wave" / ("IMG_" + std::to_string(i) + ".jpg"), "w");
  EXPECT_EQ(house.Run().ran, (Names{"bend/wave", "blend", "shoot/wave", "tell"}));
}

TEST(FewPhotographs, OtherMethodInTheProjectRunsItsSteps) {
  FewHouse house;
  house.Run();
  house.WriteProject(
      "poses: {rest: photos/rest, bent: photos/bent, wave: {photos: photos/wave, method: scan}}\n"
      "timeline: [rest, wave, bent]\n");
  EXPECT_EQ(house.Run().ran, (Names{"blend", "match/wave", "shape/wave", "solve/wave", "tell"}));
}

TEST(FewPhotographs, ProjectsWithoutThemRunNothingAfterTheUpdate) {
  FakeHouse house;
  house.Run();
  const std::string animation = house.Out("animation/frame_1");
  house.default_pipeline = kWithBend;
  EXPECT_THAT(house.Run().ran, IsEmpty()) << "the fingerprints must be as before";
  EXPECT_EQ(house.Out("animation/frame_1"), animation);
}

TEST(FewPhotographs, UntilOnlyAndExplainKnowTheStep) {
  FewHouse house;
  Selection until;
  until.until = {"bend"};
  EXPECT_EQ(house.Run(until).ran,
            (Names{"bend/wave", "shape/rest", "shoot/rest", "shoot/wave", "solve/rest"}));
  house.WriteProject(
      "poses:\n  rest: photos/rest\n  bent: photos/bent\n  wave: {photos: photos/wave, method: "
      "fit, options: {bend: {depth: 4}}}\n");
  EXPECT_EQ(house.Look().Reasons("bend/wave"), "option depth: 9 -> 4\n");
  Selection only;
  only.only = {"bend/wave"};
  EXPECT_EQ(house.Run(only).ran, Names{"bend/wave"});
}

TEST(FewPhotographs, OptionsOfAStepThatNoPoseHasYetAreChecked) {
  FewHouse house;
  house.WriteProject(
      "poses: {rest: photos/rest, bent: photos/bent}\noptions: {bend: {depht: 4}}\n");
  EXPECT_THAT(MessageOf<UsageError>([&] { house.Look(); }),
              AllOf(HasSubstr("pipeline.yaml:2"), HasSubstr("step 'bend'"),
                    HasSubstr("no option 'depht'"), HasSubstr("'depth'")));
  house.WriteProject(
      "poses: {rest: photos/rest, bent: photos/bent}\noptions: {bend: {depth: no}}\n");
  EXPECT_THAT(MessageOf<UsageError>([&] { house.Look(); }), HasSubstr("'depth' is 'no'"));
}

TEST(FewPhotographs, OptionsOfAScannedPoseForTheFitAreChecked) {
  FewHouse house;
  house.WriteProject(
      "poses:\n  rest: photos/rest\n  bent: {photos: photos/bent, options: {bend: {depht: 4}}}\n"
      "  wave: {photos: photos/wave, method: fit}\n");
  EXPECT_THAT(MessageOf<UsageError>([&] { house.Look(); }),
              AllOf(HasSubstr("pipeline.yaml:3"), HasSubstr("no option 'depht'")));
}

TEST(FewPhotographs, OptionsMayBeForOneMethodOnly) {
  FewHouse house;
  const std::string shoot = "  shoot: {stage: shoot, for: pose, inputs: {photos: $photos}";
  house.default_pipeline.replace(house.default_pipeline.find(shoot), shoot.size(),
                                 shoot + ", options: {tone: {fit: bright}}");
  const auto tone = [&](const std::string& id) {
    const auto view = house.Look();
    return view.graph->steps[view.graph->Find(id).front()].options.at("tone");
  };
  EXPECT_EQ(tone("shoot/rest"), "plain") << "the default, with the fingerprint of old projects";
  EXPECT_EQ(tone("shoot/wave"), "bright");
  const std::string poses =
      "poses: {rest: photos/rest, wave: {photos: photos/wave, method: fit}}\n";
  house.WriteProject(poses + "options: {shoot: {tone: dark}}\n");
  EXPECT_EQ(tone("shoot/wave"), "dark") << "the project decides";
  house.WriteProject(poses + "steps: {shoot: {options: {tone: dark}}}\n");
  EXPECT_EQ(tone("shoot/wave"), "dark") << "the project's step decides";
  house.WriteProject(poses + "steps: {shoot: {options: {tone: {few: dark}}}}\n");
  EXPECT_THAT(MessageOf<UsageError>([&] { house.Run(); }),
              AllOf(HasSubstr("pipeline.yaml:2"), HasSubstr("no key 'few'")));
}

TEST(FewPhotographs, TemplateCannotBeFitted) {
  FewHouse house;
  house.WriteProject("poses:\n  rest: {method: fit}\n  bent: photos/bent\n");
  EXPECT_THAT(MessageOf<UsageError>([&] { house.Run(); }),
              AllOf(HasSubstr("pipeline.yaml:2: pose 'rest' is the template"),
                    HasSubstr("needs a scan"), HasSubstr("another pose the template")));
}

TEST(FewPhotographs, UnknownMethodNamesTheKnownOnes) {
  FewHouse house;
  house.WriteProject("poses:\n  rest: photos/rest\n  bent: {method: fitt}\n");
  EXPECT_THAT(MessageOf<UsageError>([&] { house.Run(); }),
              AllOf(HasSubstr("pipeline.yaml:3"), HasSubstr("fitt"), HasSubstr("fit")));
}

TEST(FewPhotographs, StepOfTheProjectThatNeedsAScanIsTold) {
  FewHouse house;
  house.WriteProject(
      "poses: {rest: photos/rest, wave: {photos: photos/wave, method: fit}}\n"
      "steps:\n  more: {stage: shape, for: pose, inputs: {model: solve.model}}\n");
  EXPECT_THAT(MessageOf<UsageError>([&] { house.Run(); }),
              AllOf(HasSubstr("there is no step solve/wave"), HasSubstr("few photographs"),
                    HasSubstr("`method: scan`")));
}

TEST(FewPhotographs, SelectorsTakeThePosesThatHaveTheStep) {
  FewHouse house;
  house.WriteProject(
      "poses: {rest: photos/rest, bent: photos/bent, wave: {photos: photos/wave, method: fit}}\n"
      "steps:\n"
      "  all: {stage: blend, for: project, inputs: {keys: shape.mesh@all}, out: {frames: all}}\n"
      "  few: {stage: blend, for: project, inputs: {keys: bend.bent@others}, out: {frames: "
      "few}}\n");
  house.Run();
  EXPECT_TRUE(house.disk.Stat(house.project / "out/all/frame_1"));
  EXPECT_FALSE(house.disk.Stat(house.project / "out/all/frame_2"));
  EXPECT_TRUE(house.disk.Stat(house.project / "out/few/frame_0"));
  EXPECT_FALSE(house.disk.Stat(house.project / "out/few/frame_1"));
}

TEST(FewPhotographs, CamerasThatTheyHaveNoUseForAreNamed) {
  FewHouse house;
  house.disk.Write(house.project / "cameras/wave/cameras.txt", "c");
  house.WriteProject(
      "poses:\n  rest: photos/rest\n  wave: {photos: photos/wave, method: fit, cameras: "
      "cameras/wave}\n");
  EXPECT_THAT(house.Run().notes, ::testing::Contains(HasSubstr("the cameras cameras/wave of pose "
                                                               "'wave' are not used")));
}

TEST(FewPhotographs, FitMayBeTheOnlyOtherPose) {
  FewHouse house;
  house.WriteProject("poses: {rest: photos/rest, wave: {photos: photos/wave, method: fit}}\n");
  EXPECT_EQ(house.Run().ran, (Names{"bend/wave", "blend", "shape/rest", "shoot/rest", "shoot/wave",
                                    "solve/rest", "tell"}));
}

}  // namespace keypose::pipeline::few_photographs_test
