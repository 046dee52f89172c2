// Errors in a pipeline.yaml or on a command line: each message gives the place and what to do.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/values/errors.h"
#include "pipeline/graph/yaml_reader.h"
#include "pipeline/testing/fake_house.h"
#include "pipeline/testing/message_of.h"

namespace keypose::pipeline::faults_test {

using ::testing::AllOf;
using ::testing::HasSubstr;

struct BadFile {
  const char* yaml;
  const char* message;
};
class BadFiles : public ::testing::TestWithParam<BadFile> {};

TEST(Faults, ListsNestedTooDeepAreRefused) {
  FakeHouse house;
  house.WriteProject("poses: {rest: photos/rest}\ntimeline: " + std::string(60, '[') +
                     std::string(60, ']') + "\n");
  EXPECT_THAT(MessageOf<UsageError>([&] { house.Look(); }),
              AllOf(HasSubstr("more than 50 levels deep"),
                    HasSubstr("does an alias (`*name`) contain itself?")));
}

TEST(Faults, ValuesThatAliasesRepeatCount) {
  const std::string sixteen = "a: &a [1, 2, 3]\nb: [*a, *a]\n";
  EXPECT_NO_THROW(LoadYaml(sixteen, "pipeline.yaml", 16));
  EXPECT_THAT(MessageOf<UsageError>([&] { LoadYaml(sixteen, "pipeline.yaml", 15); }),
              AllOf(HasSubstr("pipeline.yaml:"), HasSubstr("millions of values")));
}

TEST_P(BadFiles, IsAnErrorWithFileAndLine) {
  FakeHouse house;
  house.WriteProject(GetParam().yaml);
  EXPECT_THAT(MessageOf<Error>([&] { house.Look(); }), HasSubstr(GetParam().message));
  EXPECT_TRUE(house.processes.calls.empty());
}

INSTANTIATE_TEST_SUITE_P(
    Faults, BadFiles,
    ::testing::Values(
        BadFile{"posse: {rest: photos/rest}\n",
                "pipeline.yaml:1: the pipeline has no key 'posse'; did you mean 'poses'?"},
        BadFile{"poses:\n  rest:\n    photoes: photos/rest\n",
                "pipeline.yaml:3: pose 'rest' has no key 'photoes'; did you mean 'photos'?"},
        BadFile{"poses:\n  rest: [a, b]\n", "pipeline.yaml:2: pose 'rest' must be a map"},
        BadFile{"poses:\n  rest: photos/rest\n  rest: photos/bent\n",
                "pipeline.yaml:3: poses has the key 'rest' twice"},
        BadFile{"poses:\n  'a/b': photos/rest\n",
                "pipeline.yaml:2: the pose name 'a/b' may have letters"},
        BadFile{
            "poses: {rest: photos/rest}\ntimeline: [{pose: rest, at: 0, ease: \"\xdf\"}, rest]\n",
            "pipeline.yaml:2: a letter here is not UTF-8"},
        BadFile{"poses: {rest: photos/rest}\n---\nposes: {rest: photos/bent}\n",
                "a second document"},
        BadFile{"poses: {rest: photos/rest}\nsteps:\n  shape: {program: ~ann/shape}\n",
                "pipeline.yaml:3: ~ann/shape: only your own home folder"},
        BadFile{"poses: {rest: photos/rest\n", "this is not YAML"},
        BadFile{"template: rest\n", "names no pose"},
        BadFile{
            "poses: {rest: photos/rest}\ntemplate: rset\n",
            "pipeline.yaml:2: the template 'rset' is not among the poses; did you mean 'rest'?"},
        BadFile{"poses: {rest: photos/rest}\ntimeline: [rest, bend]\n",
                "pipeline.yaml:2: timeline pose 'bend' is not among the poses"},
        BadFile{"poses: {rest: photos/rest}\ntimeline:\n  - {pose: rest, at: 1}\n  - {pose: rest, "
                "at: 0}\n",
                "pipeline.yaml:4: timeline keys must come in the order of time"},
        BadFile{"poses: {rest: photos/rest}\ntimeline: [{pose: rest, at: soon}, rest]\n",
                "pipeline.yaml:2: timeline 'at' is 'soon', but it must be a number"},
        BadFile{
            "poses: {rest: photos/rest}\ntimeline:\n  - {pose: rest, at: 0}\n  - {pose: rest, at: "
            "1, eas: in}\n",
            "pipeline.yaml:4: timeline: key 1 ('rest') has no field 'eas'; did you mean 'ease'?"},
        BadFile{"poses: {rest: photos/rest}\ntimeline:\n  lop: true\n  keys: [rest, rest]\n",
                "pipeline.yaml:3: timeline has no field 'lop'; did you mean 'loop'?"},
        BadFile{"poses: {rest: photos/rest}\ntimeline: [{pose: rest, hold: long}, rest]\n",
                "pipeline.yaml:2: timeline: key 0 ('rest'): field 'hold' is \"long\", but it must "
                "be a number"},
        BadFile{"poses: {rest: photos/rest}\ntimeline: {step: 2}\n",
                "pipeline.yaml:2: the timeline has no list `keys`"},
        BadFile{"poses: {rest: photos/rest}\ntimeline: {fps: 12, keys: [rest, rest]}\n",
                "pipeline.yaml:2: `fps` does not belong to the timeline"},
        BadFile{"poses: {rest: photos/rest}\noptions:\n  shap: {depth: 3}\n",
                "pipeline.yaml:3: options name the step 'shap', which does not exist; did you mean "
                "'shape'?"},
        BadFile{"poses: {rest: photos/rest}\noptions:\n  shape: {dept: 3}\n",
                "pipeline.yaml:3: step 'shape': stage 'shape' has no option 'dept'; did you mean "
                "'depth'?"},
        BadFile{"poses: {rest: photos/rest}\noptions:\n  shape: {depth: deep}\n",
                "pipeline.yaml:3: step 'shape': option 'depth' is 'deep', but it must be a whole "
                "number"},
        BadFile{"poses: {rest: photos/rest}\noptions:\n  shape: {depth: [1, 2]}\n",
                "pipeline.yaml:3: options.shape.depth must be a single value"},
        BadFile{"poses:\n  rest: photos/elsewhere\n",
                "pipeline.yaml:2: step 'shoot/rest' reads photos/elsewhere, which does not exist"},
        BadFile{"poses:\n  rest: photos/rest/IMG_0.jpg\n",
                "which is a file, but 'photos' must be a folder"},
        BadFile{"poses:\n  rest: {photos: photos/rest, landmarks: l.json}\n  bent: photos/bent\n",
                "pipeline.yaml:2: the landmarks l.json of pose 'rest' do not exist"},
        BadFile{"poses: {rest: photos/rest}\nsteps:\n  extra: {stage: solve, inputs: {images: "
                "shoot.images}}\n",
                "pipeline.yaml:3: step 'extra' needs `for:`"},
        BadFile{"poses: {rest: photos/rest}\nsteps:\n  extra: {stage: slove, for: pose}\n",
                "pipeline.yaml:3: step 'extra': there is no stage 'slove'"},
        BadFile{"poses: {rest: photos/rest}\nsteps:\n  extra: {program: ./none, for: pose}\n",
                "pipeline.yaml:3: step 'extra': there is no program"},
        BadFile{"poses: {rest: photos/rest}\nsteps:\n  shape: {inputs: {model: sovle.model}}\n",
                "pipeline.yaml:3: step 'shape': there is no step 'sovle'; did you mean 'solve'?"},
        BadFile{"poses: {rest: photos/rest}\nsteps:\n  shape: {inputs: {model: solve.modle}}\n",
                "stage 'solve' has no output 'modle'; did you mean 'model'?"},
        BadFile{"poses: {rest: photos/rest}\nsteps:\n  shape: {inputs: {modle: solve.model}}\n",
                "stage 'shape' has no input 'modle'; did you mean 'model'?"},
        BadFile{"poses: {rest: photos/rest}\nsteps:\n  shape: {inputs: {model: shoot.images}}\n",
                "shoot/rest.images is a folder, but the input 'model' takes a file"},
        BadFile{"poses: {rest: photos/rest}\nsteps:\n  shape: {inputs: {model: }}\n",
                "has nothing for the input 'model'"},
        BadFile{"poses: {rest: photos/rest}\nsteps:\n  shape: {inputs: {model: [solve.model, "
                "solve.model]}}\n",
                "takes one thing, not 2"},
        BadFile{"poses: {rest: photos/rest}\nsteps:\n  shape: {inputs: {model: $model}}\n",
                "'$model' is not known"},
        BadFile{"poses: {rest: photos/rest}\nsteps:\n  shape: {for: poses}\n",
                "pipeline.yaml:3: `for: poses` is not known; did you mean 'pose'?"},
        BadFile{"poses: {rest: photos/rest}\nsteps:\n  solve: {enabled: false}\n",
                "takes 'solve.model', but that step is switched off at pipeline.yaml:3"},
        BadFile{"poses: {rest: photos/rest}\nsteps:\n  solve: {out: {model: ../escape.txt}}\n",
                "must lie inside out/"},
        BadFile{
            "poses: {rest: photos/rest}\nsteps:\n  solve: {out: {model: 'rest/mesh.txt'}}\n",
            "two steps write one result: solve/rest and shape/rest both write out/rest/mesh.txt"},
        BadFile{"poses: {rest: photos/rest}\nsteps:\n  solve: {out: {model: 'rest'}}\n",
                "two steps write one result"}));

TEST(Faults, CycleIsNamedWithFileAndLine) {
  FakeHouse house;
  house.WriteProject(
      "poses: {rest: photos/rest}\n"
      "steps:\n"
      "  first: {stage: shape, for: pose, inputs: {model: second.mesh}}\n"
      "  second: {stage: shape, for: pose, inputs: {model: first.mesh}}\n");
  EXPECT_THAT(
      MessageOf<UsageError>([&] { house.Look(); }),
      HasSubstr(
          "pipeline.yaml:3: the steps form a cycle: first/rest -> second/rest -> first/rest"));
}

TEST(Faults, SetIsCheckedLikeTheFile) {
  FakeHouse house;
  EXPECT_THAT(MessageOf<UsageError>([&] { house.Look({}, {"shape.dept=1"}); }),
              HasSubstr("did you mean 'depth'?"));
  EXPECT_THAT(MessageOf<UsageError>([&] { house.Look({}, {"shap.depth=1"}); }),
              HasSubstr("did you mean 'shape'?"));
  EXPECT_THAT(MessageOf<UsageError>([&] { house.Look({}, {"shape.depth=1.5"}); }),
              HasSubstr("must be a whole number"));
  EXPECT_THAT(MessageOf<UsageError>([&] { house.Look({}, {"shape/best.depth=1"}); }),
              HasSubstr("did you mean 'shape/"));
  EXPECT_THAT(MessageOf<UsageError>([&] { house.Look({}, {"depth=1"}); }),
              HasSubstr("STEP.OPTION=VALUE"));
}

TEST(Faults, SourceThatVanishesIsAnInputError) {
  FakeHouse house;
  house.Run();
  house.disk.Remove(house.project / "photos/bent");
  EXPECT_THAT(MessageOf<InputError>([&] { house.Look(); }),
              HasSubstr("photos/bent, which does not exist; put it at /home/ann/hero/photos/bent"));
}

}  // namespace keypose::pipeline::faults_test
