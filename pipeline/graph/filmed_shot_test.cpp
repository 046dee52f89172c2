// Projects with a filmed shot: steps that exist only with one, the timeline from its frames, and
// what is refused.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/values/errors.h"
#include "pipeline/graph/pipeline_file.h"
#include "pipeline/testing/fake_house.h"
#include "pipeline/testing/message_of.h"

namespace keypose::pipeline::filmed_shot_test {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

/// solve makes each pose's mesh, blend the animation; match stands for locate, shape for composite.
const char* const kSteps = R"(steps:
  sfm:
    stage: solve
    for: pose
    inputs: {images: $photos}
  interpolate:
    stage: blend
    for: animation
    inputs: {keys: {template: sfm.model, others: sfm.model}, timeline: $timeline}
    out: {frames: animation}
  locate:
    stage: match
    for: animation
    when: [$film]
    inputs: {source: sfm.model@template, target: $film, landmarks: {either: [$set, $plate, $film]}}
    out: {matched: shot/shot.txt}
)";

const char* const kPoses = "poses: {rest: photos/rest, wave: photos/wave}\n";

struct Set : FakeHouse {
  Set() {
    default_pipeline = kSteps;
    for (const char* pose : {"rest", "wave"}) disk.Write(project / "photos" / pose / "1.jpg", pose);
    disk.Write(project / "film.txt", "frames");
    disk.Write(project / "plate.txt", "empty set");
  }
};

TEST(FilmedShot, StepsExistOnlyWithAFilm) {
  Set set;
  set.WriteProject(kPoses);
  EXPECT_EQ(set.Run().ran, (Names{"interpolate", "sfm/rest", "sfm/wave"}));
  set.WriteProject(std::string(kPoses) + "shot: {film: film.txt, shows: {0: rest, 4: wave}}\n");
  const auto outcome = set.Run();
  EXPECT_EQ(outcome.result.code, ExitCode::kOk) << outcome.result.message;
  EXPECT_EQ(outcome.ran, (Names{"interpolate", "locate"}))
      << "the film's frames give the keys their times";
  EXPECT_THAT(set.Out("shot/shot.txt"), AllOf(HasSubstr("frames"), Not(HasSubstr("empty set"))));
  set.WriteProject(std::string(kPoses) +
                   "shot: {film: film.txt, plate: plate.txt, shows: {0: rest, 4: wave}}\n");
  EXPECT_EQ(set.Run().ran, Names{"locate"});
  EXPECT_THAT(set.Out("shot/shot.txt"), HasSubstr("empty set"));
  EXPECT_THAT(set.Run().ran, IsEmpty());
  set.disk.Write(set.project / "set.txt", "a box");
  set.WriteProject(std::string(kPoses) +
                   "shot: {film: film.txt, plate: plate.txt, set: set.txt, "
                   "shows: {0: rest, 4: wave}}\n");
  EXPECT_EQ(set.Run().ran, Names{"locate"});
  EXPECT_THAT(set.Out("shot/shot.txt"), HasSubstr("a box"));
}

TEST(FilmedShot, OptionsForTheFilmAreCheckedBeforeThereIsOne) {
  Set set;
  set.WriteProject(std::string(kPoses) + "options: {locate: {nothing: 4}}\n");
  EXPECT_THAT(MessageOf<UsageError>([&] { set.Look(); }),
              ::testing::AllOf(HasSubstr("pipeline.yaml:2"), HasSubstr("no option 'nothing'")));
}

TEST(FilmedShot, FramesGiveTheTimeline) {
  const PipelineFile file = ParsePipelineFile(
      std::string(kPoses) + "shot: {film: f, fps: 12, shows: {6: wave, 2: rest, 12: rest}}\n",
      "pipeline.yaml");
  ASSERT_EQ(file.timeline.size(), 3u);
  EXPECT_EQ(file.timeline[0].pose.text, "rest");
  EXPECT_EQ(file.timeline[1].pose.text, "wave");
  EXPECT_THAT(
      file.timeline_json,
      AllOf(HasSubstr("\"fps\": 24"), HasSubstr("\"time\": 0.333333333"),
            HasSubstr("\"time\": 0.833333333"), HasSubstr("\"interpolation\": \"linear\"")));
  const PipelineFile own =
      ParsePipelineFile(std::string(kPoses) +
                            "timeline: [{pose: rest, at: 0}, {pose: wave, at: 1}]\n"
                            "shot: {film: f, shows: {0: rest, 12: wave}}\n",
                        "pipeline.yaml");
  EXPECT_THAT(own.timeline_json, Not(HasSubstr("linear"))) << "the project's own timeline stays";
}

TEST(FilmedShot, ShownFramesMustBeThoseOfTheFilmBeforeAnythingRuns) {
  Set set;
  for (const char* name : {"take_1001.png", "take_1003.png", "take_1005.png"})
    set.disk.Write(set.project / "film" / name, "p");
  const auto fault = [&](const std::string& shows) {
    set.WriteProject(std::string(kPoses) + "shot:\n  film: film\n  shows: " + shows + "\n");
    return MessageOf<UsageError>([&] { set.Look(); });
  };
  EXPECT_THAT(fault("{1001: rest, 1005: wave}"),
              AllOf(HasSubstr("pipeline.yaml:4"), HasSubstr("no frame 1001"),
                    HasSubstr("take_1001.png is frame 0 and take_1005.png frame 4")));
  EXPECT_THAT(fault("{0: rest, 1: wave}"), HasSubstr("no frame 1;"));
  // The stage that stands for locate takes a file, and says so once the frames are right.
  const auto fits = [&] {
    set.WriteProject(std::string(kPoses) + "shot: {film: film, shows: {0: rest, 4: wave}}\n");
    return MessageOf<InputError>([&] { set.Look(); });
  };
  EXPECT_THAT(fits(), HasSubstr("'target' must be a file"));
  set.disk.Write(set.project / "film/no_number.png", "p");
  EXPECT_THAT(fits(), HasSubstr("'target' must be a file")) << "locate names it";
}

TEST(FilmedShot, WhatIsRefused) {
  Set set;
  const auto fault = [&](const std::string& shot) {
    set.WriteProject(kPoses + shot);
    return MessageOf<UsageError>([&] { set.Run(); });
  };
  EXPECT_THAT(fault("shot: {shows: {0: rest, 4: wave}}\n"), HasSubstr("the shot has no film"));
  EXPECT_THAT(fault("shot: {film: film.txt, shows: {0: rest}}\n"),
              HasSubstr("fewer than two frames"));
  EXPECT_THAT(
      fault("shot: {film: film.txt, shows: {0: rest, 4: wvae}}\n"),
      AllOf(HasSubstr("pipeline.yaml:2"), HasSubstr("the shown pose 'wvae'"), HasSubstr("'wave'")));
  EXPECT_THAT(fault("shot: {film: film.txt, shows: {rest: 0, 4: wave}}\n"),
              HasSubstr("a frame of `shows`"));
  EXPECT_THAT(fault("shot: {film: film.txt, shows: {-1: rest, 4: wave}}\n"),
              HasSubstr("counted from the film's first picture"));
  EXPECT_THAT(fault("shot: {film: film.txt, fps: 10, shows: {0: rest, 4: wave}}\n"),
              HasSubstr("must be a multiple"));
  EXPECT_THAT(fault("shot: {film: film.txt, show: {0: rest}}\n"), HasSubstr("'shows'"));
  EXPECT_THAT(fault("kind: performance\nshot: {film: f, shows: {0: rest, 4: wave}}\n"),
              HasSubstr("belongs to a project of"));
}

}  // namespace keypose::pipeline::filmed_shot_test
