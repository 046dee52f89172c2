// Projects of a performance (`kind: performance`): shots, what their steps take, steps that exist
// only with a scan and marks.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/values/errors.h"
#include "pipeline/testing/fake_house.h"
#include "pipeline/testing/message_of.h"

namespace keypose::pipeline::performance_test {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

/// shape stands for track, match for transfer (stiffness for its pins), blend for export.
const char* const kPerformance = R"(steps:
  track:
    stage: solve
    for: shot
    inputs: {images: $video}
  calibrated:
    stage: shape
    for: shot
    inputs: {model: $calibration}
    out: {mesh: "{shot}/rig.txt"}
  transfer:
    stage: match
    for: shot
    when: [$scan, $marks]
    inputs: {source: track.model, target: $scan, landmarks: $marks, stiffness: $pins}
  export:
    stage: blend
    for: shot
    inputs: {keys: {either: [transfer.matched, track.model]}, timeline: {either: [$texture]}}
    out: {frames: "{shot}/animation"}
  tell:
    stage: tell
    for: project
    inputs: {run: $run}
    out: {report_page: report}
)";

struct Stage : FakeHouse {
  Stage() {
    default_pipeline = kPerformance;
    WriteProject(kHead + "shots: {walk: shots/walk, run: {video: shots/run}}\n");
    for (const char* shot : {"walk", "run"}) {
      disk.Write(project / "shots" / shot / "cam1/000.jpg", "film");
      disk.Write(project / "shots" / shot / "calibration.yml", std::string(shot) + " rig");
    }
  }
  const std::string kHead = "kind: performance\n";
};

TEST(Performance, EachShotIsTrackedAndExported) {
  Stage stage;
  const auto outcome = stage.Run();
  EXPECT_EQ(outcome.result.code, ExitCode::kOk) << outcome.result.message;
  EXPECT_EQ(outcome.ran, (Names{"calibrated/run", "calibrated/walk", "export/run", "export/walk",
                                "tell", "track/run", "track/walk"}));
  EXPECT_THAT(stage.Out("walk/rig.txt"), HasSubstr("walk rig")) << "found beside the films";
  EXPECT_EQ(stage.Out("walk/animation/frame_0"), "9wf") << "without a scan: the tracked body";
  EXPECT_THAT(stage.Run().ran, IsEmpty());
}

TEST(Performance, ScanAndMarksAddTheTransfer) {
  Stage stage;
  stage.Run();
  stage.disk.Write(stage.project / "scan.obj", "clay");
  stage.disk.Write(stage.project / "marks.json", "pairs");
  stage.WriteProject(stage.kHead + "shots: {walk: shots/walk, run: shots/run}\nscan: scan.obj\n");
  EXPECT_EQ(stage.Run().ran,
            (Names{"export/run", "export/walk", "tell", "transfer/run", "transfer/walk"}));
  EXPECT_THAT(stage.Out("run/animation/frame_0"),
              AllOf(HasSubstr("(target clay)"), HasSubstr("(landmarks pairs)")));
  stage.disk.Write(stage.project / "shots/run/cam1/000.jpg", "shot again");
  EXPECT_EQ(stage.Run().ran, (Names{"export/run", "tell", "track/run", "transfer/run"}))
      << "only that shot";
  stage.disk.Write(stage.project / "marks.json", "more pairs");
  EXPECT_EQ(stage.Run().ran,
            (Names{"export/run", "export/walk", "tell", "transfer/run", "transfer/walk"}));
}

TEST(Performance, PinsOfOneShotGoIntoItsTransferOnly) {
  Stage stage;
  for (const char* file : {"scan.obj", "marks.json", "held.json"})
    stage.disk.Write(stage.project / file, file);
  const std::string text = stage.kHead + "scan: scan.obj\nshots:\n  walk: shots/walk\n  run: ";
  stage.WriteProject(text + "shots/run\n");
  stage.Run();
  stage.WriteProject(text + "{video: shots/run, pins: held.json}\n");
  EXPECT_EQ(stage.Run().ran, (Names{"export/run", "tell", "transfer/run"}));
  EXPECT_THAT(stage.Out("run/animation/frame_0"), HasSubstr("(stiffness held.json)"));
  EXPECT_THAT(stage.Out("walk/animation/frame_0"), Not(HasSubstr("stiffness")));
  stage.disk.Remove(stage.project / "held.json");
  EXPECT_THAT(MessageOf<InputError>([&] { stage.Run(); }),
              AllOf(HasSubstr("pipeline.yaml:5"), HasSubstr("held.json")));
}

TEST(Performance, ScanWithoutMarksIsTrackedAlready) {
  Stage stage;
  stage.disk.Write(stage.project / "scan.obj", "clay");
  stage.WriteProject(stage.kHead + "shots: {walk: shots/walk}\nscan: scan.obj\n");
  EXPECT_EQ(stage.Run().ran, (Names{"calibrated/walk", "export/walk", "tell", "track/walk"}));
}

TEST(Performance, FilmsWithoutMasksHaveAStepMore) {
  Stage stage;
  const std::string track =
      "  track:\n    stage: solve\n    for: shot\n    inputs: {images: $video}\n";
  std::string& yaml = stage.default_pipeline;
  ASSERT_NE(yaml.find(track), std::string::npos);
  yaml.replace(yaml.find(track), track.size(),
               "  silhouettes: {stage: shoot, for: shot, when: [$unmasked], inputs: {photos: "
               "$unmasked}}\n"
               "  track: {stage: solve, for: shot, inputs: {images: {either: [silhouettes.images, "
               "$video]}}}\n");
  stage.disk.Write(stage.project / "shots/walk/masks/cam1/000.png", "mask");
  EXPECT_EQ(stage.Run().ran,
            (Names{"calibrated/run", "calibrated/walk", "export/run", "export/walk",
                   "silhouettes/run", "tell", "track/run", "track/walk"}));
  stage.disk.Write(stage.project / "shots/run/masks/cam1/000.png", "mask");
  const auto masked = stage.Look();
  EXPECT_EQ(masked.graph->Find("track").size(), 2u);
  EXPECT_THROW(masked.graph->Find("silhouettes"), UsageError) << "no shot needs it now";
}

TEST(Performance, RunRecordSaysItsKindAndThatOfPosesDoesNot) {
  Stage stage;
  stage.processes.stages["/bin/keypose-tell"].run = [](const FakeCall& call, MemoryDisk& d) {
    d.Write(std::filesystem::path(call.Flag("report_page")) / "index.html",
            d.Read(std::filesystem::path(call.Flag("run")) / "run.json"));
    return 0;
  };
  stage.Run();
  EXPECT_THAT(stage.Out("report/index.html"), HasSubstr("\"kind\": \"performance\""));
  FakeHouse house;
  house.processes.stages["/bin/keypose-tell"].run = stage.processes.stages["/bin/keypose-tell"].run;
  house.Run();
  EXPECT_THAT(house.Out("report/index.html"), Not(HasSubstr("\"kind\"")));
}

TEST(Performance, FaultsAreNamedWithTheirLine) {
  Stage stage;
  const auto fault = [&](const std::string& yaml) {
    stage.WriteProject(yaml);
    return MessageOf<UsageError>([&] { stage.Run(); });
  };
  EXPECT_THAT(fault(stage.kHead), HasSubstr("names no shot"));
  EXPECT_THAT(fault(stage.kHead + "poses: {rest: photos/rest}\n"),
              AllOf(HasSubstr("pipeline.yaml:2: `poses` belongs to a project of poses")));
  EXPECT_THAT(fault("poses: {rest: photos/rest}\nmarks: marks.json\n"),
              HasSubstr("pipeline.yaml:2: `marks` belongs to a project of a performance"));
  EXPECT_THAT(fault("kind: dance\n"), HasSubstr("pipeline.yaml:1: `kind: dance` is not known"));
  EXPECT_THAT(fault(stage.kHead + "shots:\n  walk: {films: shots/walk}\n"),
              HasSubstr("pipeline.yaml:3: shot 'walk' has no key 'films'"));
  EXPECT_THAT(fault(stage.kHead + "shots: {walk: shots/walk}\nsteps: {export: {when: [scan]}}\n"),
              HasSubstr("pipeline.yaml:3: step 'export': `when` takes words such as $scan"));
  stage.disk.Remove(stage.project / "shots/walk/calibration.yml");
  EXPECT_THAT(fault(stage.kHead + "shots:\n  walk: shots/walk\n"),
              AllOf(HasSubstr("pipeline.yaml:3: shot 'walk' has no calibration"),
                    HasSubstr("`calibration.*` into shots/walk")));
}

TEST(Performance, CalibrationOfTheProjectIsForAllShots) {
  Stage stage;
  stage.disk.Remove(stage.project / "shots/walk/calibration.yml");
  stage.disk.Write(stage.project / "calibration.yml", "one rig");
  stage.Run();
  EXPECT_THAT(stage.Out("walk/rig.txt"), HasSubstr("one rig"));
  EXPECT_THAT(stage.Out("run/rig.txt"), HasSubstr("run rig")) << "its own comes first";
  stage.WriteProject(
      stage.kHead + "shots: {walk: {video: shots/walk, calibration: shots/run/calibration.yml}}\n");
  stage.Run();
  EXPECT_THAT(stage.Out("walk/rig.txt"), HasSubstr("run rig"));
}

}  // namespace keypose::pipeline::performance_test
