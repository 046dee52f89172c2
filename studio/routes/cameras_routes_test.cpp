// Points of known place over the routes: kept in points.json as `keypose calibrate` reads it, and
// the cameras that follow from their clicks.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/io/pictures/image_io.h"
#include "core/io/project/known_points_io.h"
#include "core/io/project/rig_calibration.h"
#include "core/io/text/files.h"
#include "core/testing/folder.h"
#include "studio/routes/routes.h"

namespace keypose::studio::cameras_routes_test {

namespace fs = std::filesystem;
using nlohmann::json;
using ::testing::HasSubstr;

constexpr int kWidth = 640, kHeight = 480;
constexpr double kFocal = 600;

/// A lens without distortion in the middle of the picture, whose first pixel's centre is 0.
std::string Lens(const char* camera) {
  return std::string("\"") + camera +
         "\":\n  image_width: 640\n  image_height: 480\n  camera_matrix: !!opencv-matrix\n    "
         "rows: "
         "3\n    cols: 3\n    dt: d\n    data: [600, 0, 319.5, 0, 600, 239.5, 0, 0, 1]\n  "
         "distortion_coefficients: !!opencv-matrix\n    rows: 1\n    cols: 4\n    dt: d\n    data: "
         "[0, 0, 0, 0]\n";
}

class CamerasRoutes : public ::testing::Test, public TestingFolder {
 protected:
  CamerasRoutes() {
    for (const char* camera : {"cam1", "cam2"})
      for (int frame = 0; frame < 2; ++frame)
        Picture(fs::path("films") / camera / (std::to_string(frame) + ".png"), 20 * (frame + 1));
    Picture("films/background/cam2.png", 200);
    WriteFile(folder_ / "lenses.yml", "%YAML:1.0\n---\n" + Lens("cam1") + Lens("cam2"));
    WriteFile(folder_ / "pipeline.yaml", "kind: performance\nshots: {walk: films}\n");
    routes_ = std::make_unique<Routes>(folder_);
  }
  ~CamerasRoutes() override { routes_.reset(); }

  void Picture(const fs::path& file, int grey) const {
    fs::create_directories((folder_ / file).parent_path());
    WriteImage(folder_ / file, Image8(kWidth, kHeight, 3, static_cast<std::uint8_t>(grey)));
  }
  Answer Ask(const std::string& method, const std::string& path, const json& body = json::object(),
             const std::map<std::string, std::string>& query = {}) {
    return routes_->Handle({method, path, query, method == "GET" ? "" : body.dump()});
  }
  json Get() { return json::parse(Ask("GET", "/api/calibration").bytes); }
  Answer Put(const json& points, const json& clicks) {
    return Ask("PUT", "/api/calibration",
               {{"revision", Get().at("revision")}, {"points", points}, {"clicks", clicks}});
  }
  Answer Run(const std::string& lenses) {
    return Ask("POST", "/api/calibration/run", {{"lenses", lenses}, {"square_mm", 22}});
  }

  /// Six points 3 m before a camera that looks along y from (x, -3, 1), and their clicks.
  static json Points() {
    json points = json::array();
    for (int i = 0; i < 6; ++i)
      points.push_back({{"name", "p" + std::to_string(i)}, {"place", Place(i)}});
    return points;
  }
  static std::vector<double> Place(int i) { return {0.4 * (i % 3) - 0.4, 0.2 * i, 0.3 * (i / 2)}; }
  static json Clicks(const char* camera, double x) {
    json clicks = json::array();
    for (int i = 0; i < 6; ++i) {
      const auto p = Place(i);
      const double depth = p[1] + 3;
      const json pixel = {kWidth / 2 + kFocal * (p[0] - x) / depth,
                          kHeight / 2 + kFocal * (1 - p[2]) / depth};
      clicks.push_back({{"camera", camera}, {"point", "p" + std::to_string(i)}, {"pixel", pixel}});
    }
    return clicks;
  }
  static json AllClicks() {
    json clicks = Clicks("cam1", -0.5);
    for (const json& click : Clicks("cam2", 0.5)) clicks.push_back(click);
    return clicks;
  }
  std::unique_ptr<Routes> routes_;
};

TEST_F(CamerasRoutes, CamerasAreThoseOfTheFilmsShownByTheEmptySetWhereThereIsOne) {
  const json now = Get();
  EXPECT_EQ(now.at("problem"), "");
  ASSERT_EQ(now.at("cameras").size(), 2u);
  EXPECT_EQ(now.at("cameras")[0].at("still"), "the film of walk");
  EXPECT_EQ(now.at("cameras")[0].at("frames"), 2);
  EXPECT_EQ(now.at("cameras")[1].at("still"), "the empty set of walk");
  EXPECT_EQ(now.at("cameras")[1].at("frames"), 0);
  const auto grey = [&](const char* camera, const char* frame) {
    const Answer answer =
        Ask("GET", "/api/calibration/picture", {}, {{"camera", camera}, {"frame", frame}});
    return answer.status == 200 ? ReadImage(answer.file, 3).data[0] : -answer.status;
  };
  EXPECT_EQ(grey("cam1", "1"), 40);
  EXPECT_EQ(grey("cam2", "0"), 200);
  EXPECT_EQ(grey("cam2", "1"), -404);
  EXPECT_EQ(grey("cam3", "0"), -404);
  EXPECT_EQ(grey("../films/cam1", "0"), -404);
  EXPECT_EQ(grey("cam1", "-1"), -400);
}

TEST_F(CamerasRoutes, PointsAreKeptAsCalibrateReadsThem) {
  const json clicks = {{{"camera", "cam2"}, {"point", "p1"}, {"pixel", {10.25, 20}}}};
  ASSERT_EQ(Put(Points(), clicks).status, 200);
  const KnownPoints known = ReadKnownPoints(folder_ / "points.json");
  ASSERT_EQ(known.points.size(), 6u);
  EXPECT_DOUBLE_EQ(known.points[1].place.y(), 0.2);
  ASSERT_EQ(known.cameras.size(), 1u);  // that is clicked in
  EXPECT_EQ(known.cameras[0].camera, "cam2");
  EXPECT_EQ(known.cameras[0].width, kWidth);
  EXPECT_DOUBLE_EQ(known.cameras[0].clicks[0].pixel.x(), 10.25);
  EXPECT_EQ(Get().at("clicks"), clicks);
}

TEST_F(CamerasRoutes, PicturesThatTheFileNamesAreShownAndStay) {
  Picture("set/one.png", 77);
  WriteFile(folder_ / "points.json",
            R"({"schema": 1, "unit": "cm", "points": [{"name": "a", "place": [100, 0, 0]}],
                "cameras": [{"name": "roof", "picture": "set/one.png"}], "clicks": []})");
  const json now = Get();
  EXPECT_EQ(now.at("points")[0].at("place")[0], 1);  // metres
  EXPECT_EQ(now.at("cameras")[0].at("still"), "set/one.png");
  ASSERT_EQ(Put(now.at("points"), json::array()).status, 200);
  EXPECT_EQ(ReadKnownPoints(folder_ / "points.json").cameras[0].picture, "set/one.png");
}

TEST_F(CamerasRoutes, ClicksOfAPictureOfAnotherSizeStayThatUntilTheyAreTakenOut) {
  WriteFile(folder_ / "points.json",
            R"({"schema": 1, "points": [{"name": "p1", "place": [1, 0, 0]}],
                "cameras": [{"name": "cam1", "size": [64, 48]}],
                "clicks": [{"camera": "cam1", "point": "p1", "pixel": [5, 6]}]})");
  const json now = Get();
  EXPECT_THAT(now.at("cameras")[0].at("problem"), HasSubstr("64 x 48"));
  ASSERT_EQ(Put(now.at("points"), now.at("clicks")).status, 200);
  EXPECT_EQ(ReadKnownPoints(folder_ / "points.json").cameras[0].width, 64);
  ASSERT_EQ(Put(now.at("points"), json::array()).status, 200);
  EXPECT_EQ(ReadKnownPoints(folder_ / "points.json").cameras[0].width, kWidth);
  EXPECT_EQ(Get().at("cameras")[0].at("problem"), "");
}

TEST_F(CamerasRoutes, WhatIsWrongIsSaidAndNothingIsWritten) {
  const auto click = [](const json& camera, const json& point, const json& pixel) {
    return json{{{"camera", camera}, {"point", point}, {"pixel", pixel}}};
  };
  for (const json& clicks :
       {click("cam9", "p1", {1, 1}), click("cam1", "none", {1, 1}), click("cam1", "p1", {700, 1}),
        click("cam1", "p1", {-1, 1}), click("cam1", "p1", {1}), click("cam1", "p1", "x"),
        click(7, "p1", {1, 1}), json("x"), json{1, 2}, json(nullptr)})
    EXPECT_EQ(Put(Points(), clicks).status, 400) << clicks;
  for (const json& points :
       {json{{{"name", ""}, {"place", {0, 0, 0}}}}, json{{{"name", "a"}, {"place", {0, 0}}}},
        json{{{"name", "a"}, {"place", {0, 0, 1e9}}}}, json{{{"name", "a"}}}, json("x"), json{1},
        json{{{"name", "a"}, {"place", {0, 0, 0}}}, {{"name", "a"}, {"place", {1, 0, 0}}}}})
    EXPECT_EQ(Put(points, json::array()).status, 400) << points;
  EXPECT_EQ(Ask("PUT", "/api/calibration", {{"points", json::array()}}).status, 400);
  EXPECT_FALSE(fs::exists(folder_ / "points.json"));
}

TEST_F(CamerasRoutes, WhatWasChangedMeanwhileOrCannotBeReadIsNotWrittenOver) {
  const json body = {{"revision", "of before"}, {"points", Points()}, {"clicks", json::array()}};
  EXPECT_EQ(Ask("PUT", "/api/calibration", body).status, 409);
  WriteFile(folder_ / "points.json", "{\"schema\": 1");
  EXPECT_THAT(Get().at("problem"), HasSubstr("points.json"));
  EXPECT_EQ(Get().at("cameras").size(), 2u);
  const Answer refused = Put(Points(), json::array());
  EXPECT_EQ(refused.status, 400);
  EXPECT_THAT(refused.bytes, HasSubstr("mend or delete it"));
  EXPECT_EQ(ReadFile(folder_ / "points.json"), "{\"schema\": 1");
}

TEST_F(CamerasRoutes, CamerasAreCalibratedAndTheErrorOfEachClickIsTold) {
  EXPECT_THAT(Run("").bytes, HasSubstr("no point is clicked yet"));
  ASSERT_EQ(Put(Points(), AllClicks()).status, 200);
  EXPECT_EQ(Get().at("offers"), json({"films", "lenses.yml"}));
  const Answer run = Run("lenses.yml");
  ASSERT_EQ(run.status, 200) << run.bytes;
  const json result = json::parse(run.bytes).at("result");
  EXPECT_EQ(result.at("stale"), false);
  EXPECT_EQ(result.at("gone"), false);
  ASSERT_EQ(result.at("cameras").size(), 2u);
  for (const json& click : result.at("cameras")[1].at("clicks"))
    EXPECT_LT(click.at("error_px"), 0.01);  // exact clicks
  const RigCalibration rig = ReadRigCalibration(folder_ / "calibration.yml");
  const Eigen::Vector3d eye = rig.views[1].camera_from_world.Inverse().translation;
  EXPECT_LT((eye - Eigen::Vector3d(0.5, -3, 1)).norm(), 1e-3);
  EXPECT_EQ(Get().at("shots")[0].at("ours"), true);
  // A point elsewhere: the errors are of before.
  json points = Points();
  points[0]["place"][0] = 9;
  ASSERT_EQ(Put(points, AllClicks()).status, 200);
  EXPECT_EQ(Get().at("result").at("stale"), true);
}

TEST_F(CamerasRoutes, ACalibrationOfAnotherProgramIsKept) {
  WriteFile(folder_ / "calibration.yml", "mine");
  ASSERT_EQ(Put(Points(), AllClicks()).status, 200);
  ASSERT_EQ(Run("lenses.yml").status, 200);
  EXPECT_EQ(ReadFile(folder_ / "calibration.before.yml"), "mine");
  ASSERT_EQ(Run("lenses.yml").status, 200);  // its own it replaces
  EXPECT_EQ(ReadFile(folder_ / "calibration.before.yml"), "mine");
}

TEST_F(CamerasRoutes, AShotThatNamesAnotherCalibrationCanTakeThisOne) {
  WriteFile(folder_ / "pipeline.yaml",
            "kind: performance # mine\nshots: {walk: {video: films, calibration: lenses.yml}}\n");
  const auto use = [&](const json& shot) {
    return Ask("POST", "/api/calibration/use", {{"shot", shot}});
  };
  EXPECT_EQ(Get().at("shots")[0].at("calibration"), "lenses.yml");
  EXPECT_EQ(use("walk").status, 400);  // there is none yet
  WriteFile(folder_ / "calibration.yml", "mine");
  for (const json& none : {json("none"), json("../walk"), json(3), json(nullptr)})
    EXPECT_EQ(use(none).status, 400) << none;
  ASSERT_EQ(use("walk").status, 200);
  EXPECT_EQ(ReadFile(folder_ / "pipeline.yaml"),
            "kind: performance # mine\nshots: {walk: {video: films, calibration: "
            "calibration.yml}}\n");
}

TEST_F(CamerasRoutes, LensesAreTakenFromTheProjectAlone) {
  ASSERT_EQ(Put(Points(), AllClicks()).status, 200);
  for (const char* lenses :
       {"../lenses.yml", "/etc", "none", ".keypose", "--help", "pipeline.yaml"})
    EXPECT_EQ(Run(lenses).status, 400) << lenses;
  EXPECT_EQ(Ask("POST", "/api/calibration/run", {{"lenses", "films"}, {"square_mm", -1}}).status,
            400);
  EXPECT_EQ(Ask("POST", "/api/calibration/run", {{"lenses", 3}}).status, 400);
  EXPECT_FALSE(fs::exists(folder_ / "calibration.yml"));
}

TEST_F(CamerasRoutes, WhyTheyCannotBeCalibratedIsSaid) {
  json few = json::array();
  for (int i = 0; i < 3; ++i) few.push_back(AllClicks()[static_cast<std::size_t>(i)]);
  ASSERT_EQ(Put(Points(), few).status, 200);
  const Answer run = Run("lenses.yml");
  EXPECT_EQ(run.status, 400);
  EXPECT_THAT(run.bytes, HasSubstr("cam1"));
  EXPECT_FALSE(fs::exists(folder_ / "calibration.yml"));
}

TEST_F(CamerasRoutes, WithoutAPerformanceThereAreNoCameras) {
  WriteFile(folder_ / "pipeline.yaml", "poses: {rest: photos/rest}\n");
  EXPECT_EQ(Ask("GET", "/api/calibration").status, 400);
  EXPECT_EQ(Ask("POST", "/api/calibration/run").status, 400);
}

}  // namespace keypose::studio::cameras_routes_test
