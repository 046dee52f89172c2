// Projects without poses: steps of their own that take files, such as a puppet's baked takes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "core/values/errors.h"
#include "pipeline/testing/fake_house.h"
#include "pipeline/testing/message_of.h"

namespace keypose::pipeline::own_steps_test {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

const char* const kMould =
    "steps:\n  mould: {stage: shape, for: project, inputs: {model: ./clay.txt}, "
    "out: {mesh: mould.txt}}\n";

struct Bench : FakeHouse {
  explicit Bench(const std::string& yaml) {
    WriteProject(yaml);
    disk.Write(project / "clay.txt", "clay");
  }
  std::string Fault() {
    return MessageOf<UsageError>([&] { Run(); });
  }
};

TEST(OwnSteps, AFileIsEnoughWhereNoPoseIs) {
  Bench bench(kMould);
  const auto outcome = bench.Run();
  EXPECT_EQ(outcome.result.code, ExitCode::kOk) << outcome.result.message;
  EXPECT_EQ(outcome.ran, (Names{"mould", "tell"}));
  EXPECT_THAT(bench.Out("mould.txt"), HasSubstr("clay"));
  EXPECT_THAT(bench.Run().ran, IsEmpty());
  bench.disk.Write(bench.project / "clay.txt", "more clay");
  EXPECT_EQ(bench.Run().ran, (Names{"mould", "tell"}));
}

TEST(OwnSteps, TheyStandBesideThoseOfThePoses) {
  Bench bench("poses: {rest: photos/rest, bent: photos/bent}\n" + std::string(kMould));
  Names all = kAllSteps;
  all.insert(std::lower_bound(all.begin(), all.end(), "mould"), "mould");
  EXPECT_EQ(bench.Run().ran, all);
}

TEST(OwnSteps, WithoutAFileAPoseIsAskedFor) {
  EXPECT_THAT(Bench("steps: {tell: {enabled: true}}\n").Fault(), HasSubstr("names no pose"));
  EXPECT_THAT(Bench("steps: {mould: {enabled: false}}\n").Fault(), HasSubstr("names no pose"));
  EXPECT_THAT(Bench(kMould + std::string("template: rest\n")).Fault(),
              HasSubstr("'rest' is not among the poses"));
  EXPECT_THAT(Bench("steps:\n  mould: {stage: shape, for: project, inputs: {model: ./clay.txt}}\n"
                    "  more: {stage: shape, for: project, inputs: {model: solve.model}}\n")
                  .Fault(),
              HasSubstr("add @template, @others or @all"));
}

}  // namespace keypose::pipeline::own_steps_test
