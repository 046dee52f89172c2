#include "report/page/page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "report/page/sections.h"
#include "report/player/player_data.h"
#include "report/testing/minimal_report.h"
#include "report/testing/page_with_player.h"

namespace keypose::report::page_test {

using ::testing::HasSubstr;
using ::testing::Not;
std::string NoPictures(const Image8&) { return "data:image/jpeg;base64,AAAA"; }

TEST(BuildPage, IsSelfContainedAndSaysWhatIsMissing) {
  const std::string page = BuildPage(Minimal(), NoPictures);
  EXPECT_THAT(page, HasSubstr("clay &lt;dog&gt;"));
  EXPECT_THAT(page, Not(HasSubstr("clay <dog>")));
  EXPECT_THAT(page, HasSubstr("interpolate has not run"));
  EXPECT_THAT(page, HasSubstr("failed"));
  EXPECT_THAT(page, HasSubstr("a &lt; b"));  // every measurement is there
  EXPECT_THAT(page, Not(HasSubstr("http://")));
  EXPECT_THAT(page, Not(HasSubstr("<script")));
  EXPECT_THAT(page, Not(HasSubstr("<link")));
}

/// A run with steps of a stage that this project does not have.
std::string RunOfAStrangeStage() {
  return R"({"schema": 1, "project": {"name": "a", "template": "rest", "poses": ["rest", "up"]}, "steps": [
    {"stage": "polish", "title": "Polish <it>", "pose": "rest", "report": "polish.json", "described": [
      {"key": "shine", "label": "shine", "unit": "dB", "good": {"min": 20}},
      {"key": "dust", "label": "dust that is left", "unit": "share", "good": {"max": 0.1}},
      {"key": "absent", "label": "not measured", "unit": ""}]},
    {"stage": "frame", "title": "Picture frame", "pose": "", "report": "frame.json", "described": [
      {"key": "wide_m", "label": "width", "unit": "m"}]}]})";
}

std::string ReadStrange(const std::filesystem::path& path) {
  if (path == "/base/polish.json")
    return R"({"schema": 1, "measurements": {"shine": 12, "dust": 0.053, "scratches": 3}})";
  return R"({"schema": 1, "measurements": {"wide_m": 0.1875}})";
}

TEST(Sections, NamesOfMeasurementsAreWrittenForPeople) {
  EXPECT_EQ(Words("reprojection_error_px"), "reprojection error (px)");
}

TEST(BuildPage, AStageOfOnesOwnIsShownAsItDescribesItself) {
  Contents contents;
  contents.run = ParseRun(RunOfAStrangeStage(), "/base", ReadStrange);
  contents.poses.push_back({});
  contents.poses.back().name = "rest";
  const std::string page = BuildPage(contents, NoPictures);
  for (const char* expected : {"<h4>Polish &lt;it&gt;</h4>", "<h3>Picture frame</h3>",
                               "<span>width</span><b>0.1875\u00a0m</b>",
                               "<span>dust that is left</span><b>5.3\u00a0%</b>", "scratches",
                               "<span>shine</span><b><span class=off title=\"outside of what is "
                               "usual\">12\u00a0dB</span></b>"})
    EXPECT_THAT(page, HasSubstr(expected));
  EXPECT_THAT(page, Not(HasSubstr("not measured")));
}

TEST(BuildPage, WhatAPoseLacksIsNamedByTheTitlesThatOthersHave) {
  Contents contents = Minimal();
  const auto step = [](const char* stage, const char* pose) {
    StepRecord record;
    record.stage = stage;
    record.title = "the " + record.stage;
    record.pose = pose;
    return record;
  };
  contents.poses.back().name = "up";
  contents.run.steps = {step("sfm", "rest"),  step("unwrap", "rest"), step("bake", "rest"),
                        step("sfm", "wave"),  step("bake", "wave"),   step("sfm", "up"),
                        step("fit", "small"), step("polish", "small")};
  const std::string page = BuildPage(contents, NoPictures);
  EXPECT_THAT(page, HasSubstr("Not made for this pose: the bake.</p>"));
}

TEST(BuildPage, OnePoseEndsInAMeshAndThePageSaysSo) {
  Contents contents = Minimal();
  contents.run.poses = {"rest"};
  EXPECT_THAT(BuildPage(contents, NoPictures), HasSubstr("The project has only one pose"));
}

TEST(BuildPage, ShowsThePapersTablesBesideOurs) {
  Contents contents = Minimal();
  AnimationPart animation;
  animation.frames = {
      {0, 0, 0, 0, 0, true}, {0.5, 0.0123, 0.01, -0.2345, -0.3, false}, {1, 0, 0, 0, 0, true}};
  const Mesh mesh = Tetrahedron();
  animation.faces = PerFace(mesh.points, 1.01 * mesh.points, mesh.points, mesh.faces, 0.5);
  contents.animation = animation;
  const std::string page = BuildPage(contents, NoPictures);
  for (const char* expected :
       {"Hellidropter", "Party Onion Rigged", "0.0123", "\u22120.2345", "Figure 6", "0.1663"})
    EXPECT_THAT(page, HasSubstr(expected));
}

TEST(BuildJson, HoldsEveryMeasurementAndParses) {
  const nlohmann::json document = nlohmann::json::parse(BuildJson(Minimal()));
  EXPECT_EQ(document["schema"], 1);
  EXPECT_EQ(document["steps"][0]["measurements"]["images_placed"], 20);
  EXPECT_EQ(document["steps"][0]["measurements"]["levelled"], true);
  EXPECT_EQ(document["steps"][0]["measurements"]["unplaced"][0], "x.jpg");
  EXPECT_EQ(document["steps"][1]["status"], "failed");
  EXPECT_EQ(document["findings"][0]["grade"], "wrong");
  EXPECT_EQ(document["verdicts"][1]["about"], "up");
  EXPECT_EQ(document["verdicts"][1]["grade"], "wrong");
}

TEST(BuildPage, ForbidsTheBrowserToFetchAnything) {
  const std::string page = PageWithPlayer();
  EXPECT_THAT(page, HasSubstr("default-src 'none'; img-src data: blob:; style-src 'unsafe-inline'; "
                              "script-src 'unsafe-inline'"));
  for (const char* outside :
       {"src=\"http", "src=http", "href=\"http", "<link", "@import", "url(http"})
    EXPECT_EQ(page.find(outside), std::string::npos) << outside;
  EXPECT_THAT(page, HasSubstr("data-control=play"));
}

TEST(BuildPage, ThePlayersProgramLeavesRoomForPictures) {
  EXPECT_LT(std::string(PlayerScript()).size(), 700'000u);
  EXPECT_EQ(std::string(PlayerScript()).find("</script"), std::string::npos);
}

}  // namespace keypose::report::page_test
