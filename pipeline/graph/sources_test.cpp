// The table `sources`: words of a project's own, defaults, what is refused.
#include "pipeline/graph/sources.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/io/text/files.h"
#include "core/testing/paths.h"
#include "core/values/errors.h"
#include "pipeline/testing/fake_house.h"
#include "pipeline/testing/message_of.h"

namespace keypose::pipeline::sources_test {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

const char* const kPoses = "poses: {rest: photos/rest, bent: photos/bent}\n";

/// Steps of the project's own on words of its own.
const char* const kWire =
    "sources: {armature: {of: pose, default: \"armature/{pose}.json\"}}\n"
    "steps:\n"
    "  wire: {stage: shape, for: pose, when: [$armature], inputs: {model: $armature}, "
    "out: {mesh: \"{pose}/wire.txt\"}}\n";
const char* const kJoints =
    "sources:\n"
    "  joints: {of: pair, default: \"joints/{pose}.json\", unpaired: \"measure {pose} too\"}\n"
    "steps: {match: {inputs: {landmarks: $joints}}}\n";

struct Desk : FakeHouse {
  explicit Desk(const std::string& yaml) { WriteProject(yaml); }
  void File(const std::string& name, const std::string& text) { disk.Write(project / name, text); }
  std::string Fault() {
    return MessageOf<UsageError>([&] { Look(); });
  }
};

std::string FaultOf(const std::string& yaml) { return Desk(yaml).Fault(); }

TEST(Sources, PoseNamesAWordOfTheProjectsOwn) {
  Desk desk("poses: {rest: {photos: photos/rest, armature: x.json}, bent: photos/bent}\n" +
            std::string(kWire));
  desk.File("x.json", "bent wire");
  const auto outcome = desk.Run();
  EXPECT_EQ(outcome.result.code, ExitCode::kOk) << outcome.result.message;
  EXPECT_THAT(desk.Out("rest/wire.txt"), HasSubstr("bent wire"));
  EXPECT_THROW(desk.Look().graph->Find("wire/bent"), UsageError) << "that pose gives none";
  EXPECT_THAT(desk.Run().ran, IsEmpty());
  desk.File("x.json", "straight wire");
  EXPECT_THAT(desk.Run().ran, ElementsAre("tell", "wire/rest"));
}

TEST(Sources, DefaultIsTakenWhereItIsThere) {
  Desk desk(kPoses + std::string(kWire));
  EXPECT_EQ(desk.Run().ran, kAllSteps) << "no pose has one";
  desk.File("armature/bent.json", "found");
  EXPECT_THAT(desk.Run().ran, ElementsAre("tell", "wire/bent"));
  EXPECT_THAT(desk.Out("bent/wire.txt"), HasSubstr("found"));
}

TEST(Sources, WithAlwaysAMissingDefaultIsAnError) {
  Desk desk(
      "poses: {rest: photos/rest}\n"
      "sources: {armature: {of: pose, default: \"armature/{pose}.json\", always: true}}\n"
      "steps: {wire: {stage: shape, for: pose, inputs: {model: $armature}}}\n");
  EXPECT_THAT(MessageOf<InputError>([&] { desk.Look(); }),
              AllOf(HasSubstr("pipeline.yaml:1: step 'wire/rest' reads armature/rest.json"),
                    HasSubstr("does not exist; put it at")));
}

TEST(Sources, RequiredSaysWhatIsWrittenInTheTable) {
  EXPECT_THAT(FaultOf("poses:\n  rest: photos/rest\n"
                      "sources:\n"
                      "  wire: {of: pose, default: \"wire/{pose}.json\"}\n"
                      "  rig: {of: pose, default: \"{photos}/rig.*\", required: \"pose '{pose}' "
                      "has no rig; put one into {photos}\"}\n"
                      "steps: {wire: {stage: shape, for: pose, inputs: {model: $rig}}}\n"),
              HasSubstr("pipeline.yaml:2: pose 'rest' has no rig; put one into photos/rest"));
}

TEST(Sources, PairTakesBothOrNone) {
  Desk desk(kPoses + std::string(kJoints));
  desk.File("joints/rest.json", "rest joints");
  const auto alone = desk.Run();
  EXPECT_THAT(alone.notes,
              ElementsAre(AllOf(HasSubstr("joints/rest.json is not used: pose 'bent' has no joints "
                                          "to pair them with; measure bent too"))));
  EXPECT_THAT(desk.Out("animation/frame_1"), Not(HasSubstr("joints")));
  desk.File("joints/bent.json", "bent joints");
  const auto both = desk.Run();
  EXPECT_THAT(both.notes, IsEmpty());
  EXPECT_THAT(desk.Out("animation/frame_1"), HasSubstr("(landmarks rest joints bent joints)"));
  desk.WriteProject(
      "poses:\n  rest: photos/rest\n  bent: {photos: photos/bent, joints: other.json}\n" +
      std::string(kJoints));
  EXPECT_THAT(MessageOf<InputError>([&] { desk.Look(); }),
              HasSubstr("pipeline.yaml:3: the joints other.json of pose 'bent' do not exist; put "
                        "them there"));
}

TEST(Sources, ProjectNamesItsOwnAtTheTop) {
  const std::string steps =
      "sources: {base: {of: project, default: base.txt}}\n"
      "steps: {base: {stage: shape, for: project, when: [$base], inputs: {model: $base}, out: "
      "{mesh: base.txt}}}\n";
  Desk desk(kPoses + steps);
  EXPECT_EQ(desk.Run().ran, kAllSteps);
  desk.File("base.txt", "round");
  EXPECT_THAT(desk.Run().ran, ElementsAre("base", "tell"));
  desk.File("square.txt", "square");
  desk.WriteProject(kPoses + steps + "base: square.txt\n");
  EXPECT_THAT(desk.Run().ran, ElementsAre("base", "tell"));
  EXPECT_THAT(desk.Out("base.txt"), HasSubstr("square"));
}

TEST(Sources, FilmedShotNamesItsOwn) {
  Desk desk(kPoses + std::string("shot: {film: film.txt, shows: {0: rest, 4: bent}, mist: m.txt}\n"
                                 "sources: {mist: {of: shot}}\n"
                                 "steps: {fog: {stage: shape, for: project, inputs: {model: "
                                 "$mist}, out: {mesh: fog.txt}}}\n"));
  desk.File("film.txt", "film");
  desk.File("m.txt", "grey");
  EXPECT_EQ(desk.Run().result.code, ExitCode::kOk);
  EXPECT_THAT(desk.Out("fog.txt"), HasSubstr("grey"));
}

TEST(Sources, MisspeltKeysNameLineAndNearestWord) {
  EXPECT_THAT(FaultOf("poses:\n  rest:\n    armatur: x.json\n" + std::string(kWire)),
              HasSubstr("pipeline.yaml:3: pose 'rest' has no key 'armatur'; did you mean "
                        "'armature'?"));
  EXPECT_THAT(FaultOf("poses:\n  rest:\n    armatur: [x.json]\n" + std::string(kWire)),
              HasSubstr("has no key 'armatur'"))
      << "the key's fault comes before that of its value";
  EXPECT_THAT(FaultOf("poses:\n  rest:\n    armature: [x.json]\n" + std::string(kWire)),
              HasSubstr("pipeline.yaml:3: armature must be a single value"));
  EXPECT_THAT(FaultOf(kPoses + std::string("stifness: a.json\n")),
              HasSubstr("pipeline.yaml:2: the pipeline has no key 'stifness'; did you mean "
                        "'stiffness'?"));
  EXPECT_THAT(FaultOf("poses: {rest: photos/rest}\ntexture: skin.png\n"),
              HasSubstr("has no key 'texture'; that is of a pose: it stands below one in `poses`"));
  EXPECT_THAT(FaultOf("poses: {rest: photos/rest}\nsteps:\n  shape: {inputs: {model: $mash}}\n"),
              HasSubstr("pipeline.yaml:3: step 'shape': '$mash' is not known; did you mean "
                        "'$mesh'?"));
  EXPECT_THAT(FaultOf("poses: {rest: photos/rest}\nsteps:\n  shape: {when: [$mash]}\n"),
              HasSubstr("'$mash' is not known; did you mean '$mesh'?"));
  EXPECT_THAT(FaultOf(kPoses + std::string("steps: {tell: {when: [$masks]}}\n")),
              HasSubstr("step 'tell': the step is not of one pose, so it has no $masks"));
}

TEST(Sources, FaultsOfTheTableAreNamed) {
  const auto table = [](const std::string& line) {
    return FaultOf(kPoses + ("sources:\n  " + line + "\n"));
  };
  for (const char* word : {"method", "options", "timeline", "shows", "fps", "run", "pose"})
    EXPECT_THAT(table(std::string(word) + ": {of: pose}"),
                HasSubstr("pipeline.yaml:3: '" + std::string(word) + "' cannot be a source"));
  EXPECT_THAT(table("photos: {of: pose}"),
              HasSubstr("pipeline.yaml:3: there is a source 'photos' already, at pipeline.yaml:"));
  EXPECT_THAT(table("a b: {of: pose}"), HasSubstr("the source 'a b' may have letters"));
  EXPECT_THAT(table("wire: x.json"), HasSubstr("source 'wire' must be a map"));
  EXPECT_THAT(table("wire: {default: x.json}"), HasSubstr("does not say whose it is"));
  EXPECT_THAT(table("wire:"), HasSubstr("does not say whose it is"));
  EXPECT_THAT(table("wire: {of: poses}"), HasSubstr("`of: poses` is not known"));
  EXPECT_THAT(table("wire: {of: pose, defalt: x}"), HasSubstr("did you mean 'default'?"));
  EXPECT_THAT(table("wire: {of: pose, always: true}"), HasSubstr("needs one default"));
  EXPECT_THAT(table("wire: {of: project, default: \"{pose}.json\"}"),
              HasSubstr("the default of source 'wire' has {pose}, which is not known"));
  EXPECT_THAT(table("wire: {of: pose, default: \"{photo}/w.json\"}"),
              HasSubstr("did you mean 'photos'?"));
  Desk wrong("");
  wrong.default_pipeline += "stpes: {}\n";
  wrong.WriteProject(kPoses);
  EXPECT_THAT(wrong.Fault(), HasSubstr("default.yaml:"));
}

TEST(Sources, ShippedTablesAgreeWithThoseWhoReadAProjectsFileAlone) {
  PoseRule pose;
  pose.name = "x";
  const auto shipped = [](const std::string& file, const char* word) {
    const PipelineFile table = ParsePipelineFile(ReadFile(SourceFolder() + "/" + file), file);
    for (const SourceRule& rule : table.sources)
      if (rule.word == word) return rule.always ? rule.defaults.at(0).text : "";
    return std::string();
  };
  pose.name = "{pose}";
  EXPECT_EQ(shipped("pipeline.yaml", kPhotosWord), PhotographsOf(pose));
  pose.name = "{shot}";
  EXPECT_EQ(shipped("performance.yaml", kVideoWord), VideoOf(pose));
}

}  // namespace keypose::pipeline::sources_test
