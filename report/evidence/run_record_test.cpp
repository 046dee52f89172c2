#include "report/evidence/run_record.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/values/errors.h"
#include "report/testing/minimal_report.h"

namespace keypose::report::run_record_test {

using ::testing::HasSubstr;

TEST(ParseRun, TakesStepsPathsAndMeasurements) {
  const RunRecord run = ParseRun(kRun, "/base", ReadFake);
  EXPECT_EQ(run.project, "clay <dog>");
  const StepRecord* sfm = run.Find("sfm", "rest");
  ASSERT_NE(sfm, nullptr);
  EXPECT_EQ(sfm->Number("images_placed"), 20);
  EXPECT_TRUE(sfm->flags.at("levelled"));
  EXPECT_EQ(sfm->texts.at("note"), "a < b");
  EXPECT_EQ(sfm->lists.at("unplaced"), "[\"x.jpg\"]");
  EXPECT_EQ(sfm->Input("images"), "/base/images");
  EXPECT_EQ(sfm->Output("model"), "/nowhere/model");
  EXPECT_EQ(sfm->version, "3");
  EXPECT_EQ(run.Find("sfm", "up"), nullptr);
}

TEST(ParseRun, AMissingStageReportIsToldAndDoesNotEndTheReport) {
  const RunRecord run = ParseRun(kRun, "/base", ReadFake);
  EXPECT_THAT(run.Find("cleanup", "up")->trouble, HasSubstr("gone.json"));
}

TEST(ParseRun, WhatIsNoRecordIsAnInputError) {
  EXPECT_THROW(ParseRun("{", "/", ReadFake), InputError);
  EXPECT_THROW(ParseRun("[]", "/", ReadFake), InputError);
  EXPECT_THROW(ParseRun(R"({"schema": 2, "project": {"poses": []}, "steps": []})", "/", ReadFake),
               InputError);
  EXPECT_THROW(
      ParseRun(R"({"schema": 1, "project": {"poses": "rest"}, "steps": []})", "/", ReadFake),
      InputError);
}

TEST(RunRecord, ThePlayedRateIsThatOfTheExportOfTheseFrames) {
  StepRecord take, animation;
  take.stage = animation.stage = "export";
  take.id = "export_walk", take.inputs["frames"] = {"/armature/walk"}, take.options["fps"] = "12";
  animation.id = "export", animation.inputs["frames"] = {"/cache/frames"};
  animation.options["fps"] = "24.0";
  RunRecord run;
  run.steps = {take, animation};
  EXPECT_EQ(run.ExportedRate("/cache/frames"), 24) << "a puppet's take comes first in the record";
  EXPECT_EQ(run.ExportOf("/cache/frames")->id, "export");
  EXPECT_EQ(run.ExportedRate("/cache/others"), 0);
  run.steps[1].options["fps"] = "0";
  EXPECT_EQ(run.ExportedRate("/cache/frames"), 0);
}

}  // namespace keypose::report::run_record_test
