#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <regex>
#include <sstream>

#include "core/testing/folder.h"
#include "core/testing/paths.h"
#include "core/values/errors.h"
#include "report/contents.h"
#include "report/html.h"
#include "report/pictures.h"
#include "report/sections.h"

namespace keypose::report::report_test {

using ::testing::HasSubstr;
using ::testing::Not;

Mesh Tetrahedron(double size = 1, double lift = 0) {
  Mesh mesh;
  mesh.points.resize(4, 3);
  mesh.points << 0, 0, lift, size, 0, lift, 0, size, lift, 0, 0, size + lift;
  mesh.faces.resize(4, 3);
  mesh.faces << 0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3;
  return mesh;
}

const char* const kRun =
    R"({"schema": 1, "project": {"name": "clay <dog>", "template": "rest", "poses": ["rest", "up"]}, "timeline": null, "steps": [
  {"id": "sfm/rest", "step": "sfm", "stage": "sfm", "pose": "rest", "status": "done", "seconds": 12.5, "peak_bytes": 400000000, "cached": true,
   "fingerprint": "abcdef0123456789", "report": "sfm.json", "outputs": {"model": "/nowhere/model"}, "inputs": {"images": ["images"]}},
  {"id": "cleanup/up", "step": "cleanup", "stage": "cleanup", "pose": "up", "status": "failed", "report": "gone.json"}]})";

std::string ReadFake(const std::filesystem::path& path) {
  if (path == "/base/sfm.json")
    return R"({"schema": 1, "stage": "sfm", "version": "3", "options": {"camera": "opencv"}, "seconds": 12.5, "peak_bytes": 4,
              "measurements": {"images_total": 36, "images_placed": 20, "reprojection_error_px": 0.51, "levelled": true, "note": "a < b", "unplaced": ["x.jpg"]}})";
  throw DiskError("cannot open " + path.string());
}

Contents Minimal() {
  Contents contents;
  contents.run = ParseRun(kRun, "/base", ReadFake);
  contents.poses.push_back({});
  contents.poses.back().name = "rest";
  return contents;
}

std::string NoPictures(const Image8&) { return "data:image/jpeg;base64,AAAA"; }

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

TEST(DistanceTo, ShiftedCopyLiesItsShiftApart) {
  Mesh inner = Tetrahedron(), outer = Tetrahedron();
  outer.points.rowwise() += Eigen::RowVector3d(0, 0, 0.25);
  // Measured from the shifted copy: its top corner is 0.25 above the other's top corner; its base
  // is 0.25 above the other's base, but closer to the other's sides.
  const OneWayDistance way = DistanceTo(outer, inner, 20000);
  EXPECT_NEAR(way.max, 0.25, 1e-12);
  EXPECT_NEAR(way.at_vertex[3], 0.25, 1e-12);
  EXPECT_NEAR(way.at_vertex[0], 0, 1e-12);  // on the inner's edge
  EXPECT_LT(way.mean, way.rms);
  EXPECT_LE(way.p99, way.max);
  const OneWayDistance same = DistanceTo(inner, inner, 1000);
  EXPECT_NEAR(same.max, 0, 1e-9);
}

TEST(ParseDistortion, RatiosAndRelativeValuesGiveTheSameTables) {
  const std::string ratios = R"({"key_frames": [0, 3], "frames": [
    {"t": 0, "area": 1, "volume": 1, "linear_area": 1, "linear_volume": 1}, {"t": 0.3, "area": 1.01, "volume": 1.02, "linear_area": 0.9, "linear_volume": 0.8},
    {"t": 0.6, "area": 1.03, "volume": 1.02, "linear_area": 0.8, "linear_volume": 0.6}, {"t": 1, "area": 1.5, "volume": 1.5, "linear_area": 1.5, "linear_volume": 1.5}]})";
  const std::string relative = R"({"frames": [
    {"t": 0, "area": 0, "volume": 0, "linear_area": 0, "linear_volume": 0}, {"t": 0.3, "area": 0.01, "volume": 0.02, "linear_area": -0.1, "linear_volume": -0.2},
    {"t": 0.6, "area": 0.03, "volume": 0.02, "linear_area": -0.2, "linear_volume": -0.4}, {"t": 1, "area": 0.5, "volume": 0.5, "linear_area": 0.5, "linear_volume": 0.5}]})";
  for (const std::string& text : {ratios, relative}) {
    const std::vector<FrameDistortion> frames = ParseDistortion(text);
    const DistortionRow area = AreaRow(frames), volume = VolumeRow(frames);
    EXPECT_EQ(area.frames, 2);  // without the keys
    EXPECT_NEAR(area.mean, 0.02, 1e-12);
    EXPECT_NEAR(area.deviation, 0.01, 1e-12);
    EXPECT_NEAR(area.linear_mean, -0.15, 1e-12);
    EXPECT_NEAR(volume.linear_deviation, 0.1, 1e-12);
    EXPECT_NEAR(volume.deviation, 0, 1e-12);
  }
}

TEST(ParseDistortion, ReadsThePathAndCountsAHeldKeyAsNoInBetween) {
  const std::string text = R"({"key_frames": [0, 3], "frames": [
    {"t": 0, "time": 2, "area": 1, "volume": 1, "linear_area": 1, "linear_volume": 1, "area_path": 1, "volume_path": 1},
    {"t": 0, "time": 2.1, "area": 1, "volume": 1, "linear_area": 1, "linear_volume": 1, "area_path": 1, "volume_path": null, "same_as": 0},
    {"t": 0.5, "time": 2.2, "area": 1.1, "volume": 1, "linear_area": 1, "linear_volume": 1, "area_path": 1.2, "volume_path": 1},
    {"t": 1, "time": 2.3, "area": 1.4, "volume": 1, "linear_area": 1, "linear_volume": 1}]})";
  const std::vector<FrameDistortion> frames = ParseDistortion(text);
  EXPECT_EQ(AreaRow(frames).frames, 1);
  EXPECT_NEAR(AreaRow(frames).mean, 0.1, 1e-12);
  EXPECT_EQ(frames[2].time_s, 2.2);
  EXPECT_NEAR(frames[2].area_path, 0.2, 1e-12);
  EXPECT_TRUE(std::isnan(frames[1].volume_path));
  EXPECT_TRUE(std::isnan(frames[3].area_path));
}

TEST(PlayAt, FramesFollowOneAnotherAtTheRateOfTheExport) {
  std::vector<FrameDistortion> frames(3);
  frames[0].time_s = 2, frames[1].time_s = 2.04, frames[2].time_s = 2.08;
  PlayAt(12.5, &frames);
  EXPECT_EQ(frames[0].time_s, 2);
  EXPECT_DOUBLE_EQ(frames[1].time_s, 2.08);
  EXPECT_DOUBLE_EQ(frames[2].time_s, 2.16);
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

TEST(ParseDistortion, NamesTheFrameThatIsNotFinite) {
  const char* text =
      R"({"frames": [{"t": 0, "area": 0, "volume": 0, "linear_area": 0, "linear_volume": 0}, {"t": 1, "area": null}]})";
  try {
    ParseDistortion(text);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("frame 1"));
  }
  EXPECT_THROW(ParseDistortion(R"({"frames": []})"), InputError);
  EXPECT_THROW(ParseDistortion("nothing"), InputError);
}

TEST(PerFace, UniformScalingChangesEveryFaceByItsSquareAndCube) {
  const Mesh small = Tetrahedron(1), large = Tetrahedron(2);
  const FaceDistortion d =
      PerFace(small.points, 1.1 * small.points, large.points, small.faces, 0.5);
  ASSERT_EQ(d.area.size(), 4u);
  for (const double a : d.area) EXPECT_NEAR(a, 0.21, 1e-12);
  for (const double v : d.volume) EXPECT_NEAR(v, 0.331, 1e-12);
  for (const double a : d.linear_area)
    EXPECT_NEAR(a, 1.25, 1e-12);  // half-way to twice the size: 1.5^2 - 1
}

TEST(Histogram, SharesSumToOneAndTheEndsHoldWhatIsBeyond) {
  const std::vector<double> shares = Histogram({-9, -0.9, 0.1, 0.2, 7}, -1, 1, 4);
  EXPECT_EQ(shares, (std::vector<double>{0.4, 0, 0.4, 0.2}));
}

TEST(Html, EscapesEncodesAndWritesNumbersForPeople) {
  EXPECT_EQ(Escape("a<b>&\"c\""), "a&lt;b&gt;&amp;&quot;c&quot;");
  EXPECT_EQ(Base64("Man"), "TWFu");
  EXPECT_EQ(Base64("Ma"), "TWE=");
  EXPECT_EQ(Base64("M"), "TQ==");
  EXPECT_EQ(Base64(""), "");
  EXPECT_EQ(Pretty(1234567), "1\u202f234\u202f567");
  EXPECT_EQ(Pretty(0.5), "0.5000");
  EXPECT_EQ(Pretty(-2.5), "\u22122.5");
  EXPECT_EQ(PrettySeconds(245), "4 min 05 s");
  EXPECT_EQ(PrettyBytes(1.35e9), "1.35 GB");
  EXPECT_EQ(Percent(0.1234), "12.3\u00a0%");
  EXPECT_EQ(Words("reprojection_error_px"), "reprojection error (px)");
}

TEST(Charts, AreWellFormedSvg) {
  const std::string line = LineChart({{"ARAP", "#00f", {0, 0.5, 1}, {0, 0.01, 0.02}, false},
                                      {"linear", "#f00", {0, 0.5, 1}, {0, -0.3, 0}, true}},
                                     {"area", "t", "", true});
  const std::string bars =
      HistogramChart({{"ARAP", "#00f", {0.2, 0.5, 0.3}}}, -1, 1, {"faces", "d", "", true});
  for (const std::string& svg : {line, bars}) {
    EXPECT_THAT(svg, HasSubstr("ARAP"));
    EXPECT_FALSE(std::regex_search(svg, std::regex("=[^\"][^\\s>]*/>")))
        << "an unquoted value swallows the slash that ends its element";
    EXPECT_THAT(svg, Not(HasSubstr("nan")));
    const auto count = [&](const char* what) {
      int n = 0;
      for (std::size_t at = svg.find(what); at != std::string::npos; at = svg.find(what, at + 1))
        ++n;
      return n;
    };
    EXPECT_EQ(count("<text"), count("</text>"));
  }
  EXPECT_EQ(LineChart({}, {}), "");
  EXPECT_THAT(LineChart({{"flat", "#000", {0, 1}, {0, 0}, false}}, {}), Not(HasSubstr("nan")));
}

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
    return R"({"schema": 1, "measurements": {"shine": 12, "dust": 0.05, "scratches": 3}})";
  return R"({"schema": 1, "measurements": {"wide_m": 0.25}})";
}

TEST(BuildPage, AStageOfOnesOwnIsShownAsItDescribesItself) {
  Contents contents;
  contents.run = ParseRun(RunOfAStrangeStage(), "/base", ReadStrange);
  contents.poses.push_back({});
  contents.poses.back().name = "rest";
  const std::string page = BuildPage(contents, NoPictures);
  for (const char* expected :
       {"<h4>Polish &lt;it&gt;</h4>", "<h3>Picture frame</h3>", "<span>width</span><b>0.25 m</b>",
        "<span>dust that is left</span><b>5\u00a0%</b>", "scratches",
        "<span>shine</span><b><span class=off title=\"outside of what is usual\">12 dB</span></b>"})
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

TEST(FindAll, NamesAPhotographWhoseDetailsTheRenderDoesNotRepeat) {
  Contents contents = Minimal();
  std::vector<ViewEvidence> views(5);
  for (int i = 0; i < 5; ++i) {
    views[i].name = "IMG_" + std::to_string(i);
    views[i].outline_off = 0.0005, views[i].edges = 1;
    views[i].structure = i == 3 ? 0.29 : 0.9;
  }
  contents.poses[0].evidence = Summarize(views);
  const auto named = [&] {
    const std::vector<Finding> all = FindAll(contents);
    return std::count_if(all.begin(), all.end(), [](const Finding& f) {
      return f.grade == Grade::kLook && f.text.find("<b>IMG_3</b>") != std::string::npos;
    });
  };
  EXPECT_EQ(named(), 1);
  contents.poses[0].evidence.views[3].structure = 0.31;
  EXPECT_EQ(named(), 0);
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

TEST(MaskTile, DarkensWhatTheMaskLeavesOut) {
  Image8 photograph(6, 6, 3, 200), mask(6, 6, 1, 0);
  for (int y = 1; y < 5; ++y)
    for (int x = 1; x < 5; ++x) *mask.at(x, y) = 255;
  const Image8 tile = MaskTile(photograph, mask);
  EXPECT_EQ(tile.at(0, 0)[0], 80);
  EXPECT_EQ(tile.at(2, 2)[0], 200);
  EXPECT_EQ(tile.at(1, 2)[1], 140);  // the outline
}

TEST(HeatSides, FarVerticesGetTheHotEndOfTheScale) {
  SidesOptions options;
  options.azimuths_deg = {0};
  options.width = options.height = 60;
  const Mesh mesh = Tetrahedron();
  const Image8 cold = HeatSides(mesh, Eigen::VectorXd::Zero(4), 1, options)[0].image,
               hot = HeatSides(mesh, Eigen::VectorXd::Ones(4), 1, options)[0].image;
  EXPECT_GT(cold.at(25, 38)[2], cold.at(25, 38)[0]);
  EXPECT_GT(hot.at(25, 38)[0], hot.at(25, 38)[2]);
}

TEST(ReportStage, WritesAPageForARunWhoseArtifactsAreGone) {
  const TestingFolder own;
  const std::filesystem::path folder = own.path();
  std::filesystem::create_directories(folder / "run");
  std::ofstream(folder / "run/run.json") << kRun;
  const std::string f = folder.string();
  const std::string command = BinFolder() + "/keypose-report --run " + f + "/run --report " + f +
                              "/report --report " + f + "/stage.json > " + f + "/log 2>&1";
  std::ostringstream log;
  const int code = std::system(command.c_str()) >> 8;
  log << std::ifstream(folder / "log").rdbuf();
  ASSERT_EQ(code, 0) << log.str();
  std::ostringstream page;
  page << std::ifstream(folder / "report/index.html").rdbuf();
  EXPECT_THAT(page.str(), HasSubstr("no longer there"));
  EXPECT_TRUE(std::filesystem::exists(folder / "report/report.json"));
  const nlohmann::json said = nlohmann::json::parse(std::ifstream(folder / "stage.json"));
  ASSERT_EQ(said["verdicts"].size(), 2u);
  EXPECT_EQ(said["verdicts"][1]["about"], "up");
  EXPECT_EQ(said["verdicts"][1]["grade"], "wrong");
  EXPECT_THAT(std::string(said["verdicts"][1]["why"]), HasSubstr("keypose log cleanup/up"));
}

}  // namespace keypose::report::report_test
