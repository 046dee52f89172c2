#include "core/io/project/shot_io.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>

#include "core/testing/folder.h"
#include "core/values/errors.h"

namespace keypose::shot_io_test {

namespace fs = std::filesystem;
using nlohmann::json;
using ::testing::HasSubstr;

FilmedShot SomeShot() {
  FilmedShot shot;
  shot.camera = {1920, 1080, 2100.5, 2101, 958.25, 541, -0.03, 0.004, 1e-4, -2e-4};
  shot.focal = "solved", shot.focal_uncertainty = 0.012, shot.still = true, shot.fps = 12;
  const Rigid3 camera{
      Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized())),
      {0.1, -0.2, 1.5}};
  for (int i = 0; i < 2; ++i) {
    ShotFrame frame;
    frame.frame = 4 * i, frame.picture = i ? "0004.png" : "0000.png", frame.pose = i ? "" : "rest";
    frame.camera_from_world = camera;
    frame.world_from_character = {
        0.3,
        Eigen::AngleAxisd(0.2 + i, Eigen::Vector3d::UnitZ()).toRotationMatrix(),
        {0.01, 0.02 * i, 0}};
    frame.method = i ? "outlines" : "features";
    shot.frames.push_back(frame);
  }
  shot.frames[0].inliers = 71, shot.frames[1].iou = 0.993, shot.frames[1].contour_px = 0.25;
  return shot;
}

std::string FaultOf(const std::function<void(json&)>& damage) {
  json root = json::parse(ShotText(SomeShot()));
  damage(root);
  try {
    ParseShot(root.dump(), "shot.json");
  } catch (const InputError& error) {
    return error.what();
  }
  return "none";
}

TEST(ShotFile, WrittenShotReadsTheSame) {
  const FilmedShot shot = SomeShot();
  const FilmedShot again = ParseShot(ShotText(shot), "shot.json");
  EXPECT_EQ(again.camera.fx, shot.camera.fx);
  EXPECT_EQ(again.camera.p2, shot.camera.p2);
  EXPECT_EQ(again.focal, "solved");
  ASSERT_EQ(again.frames.size(), 2u);
  EXPECT_EQ(again.frames[0].pose, "rest");
  EXPECT_EQ(again.frames[1].pose, "");
  EXPECT_EQ(again.frames[0].inliers, 71);
  EXPECT_FALSE(again.frames[0].iou.has_value());
  EXPECT_EQ(again.frames[1].iou, 0.993);
  const Eigen::Vector3d x(0.3, -0.4, 0.5);
  for (int i = 0; i < 2; ++i) {
    const ShotFrame &a = shot.frames[i], &b = again.frames[i];
    EXPECT_LT((a.world_from_character * x - b.world_from_character * x).norm(), 1e-14);
    EXPECT_LT((a.camera_from_world * x - b.camera_from_world * x).norm(), 1e-14);
    EXPECT_LT(
        (CameraFromCharacter(a) * x - a.camera_from_world * (a.world_from_character * x)).norm(),
        1e-14);
  }
}

TEST(ShotFile, CamerasBetweenFramesAreKept) {
  FilmedShot shot = SomeShot();
  shot.still = false;
  shot.between = {{0.5, shot.frames[0].camera_from_world}, {2, shot.frames[1].camera_from_world}};
  shot.between[0].camera_from_world.translation.x() = 0.7;
  const json root = json::parse(ShotText(shot));
  const FilmedShot again = ParseShot(root.dump(), "shot.json");
  ASSERT_EQ(again.between.size(), 2u);
  EXPECT_EQ(again.between[0].frame, 0.5);
  EXPECT_EQ(again.between[0].camera_from_world.translation.x(), 0.7);
  const auto fault = [&](const std::function<void(json&)>& damage) {
    json damaged = root;
    damage(damaged);
    try {
      ParseShot(damaged.dump(), "shot.json");
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("none");
  };
  EXPECT_THAT(fault([](json& j) { j["still"] = true; }), HasSubstr("'still' is true"));
  EXPECT_THAT(fault([](json& j) { j["between"][1]["frame"] = 0.25; }), HasSubstr("comes after"));
  EXPECT_THAT(fault([](json& j) { j["between"][1]["frame"] = 9; }), HasSubstr("is not between"));
  EXPECT_THAT(fault([](json& j) { j["between"][0]["frame"] = -1; }), HasSubstr("'frame' -1"));
  EXPECT_THAT(fault([](json& j) { j["between"] = 3; }), HasSubstr("not a list"));
  EXPECT_THAT(fault([](json& j) { j["between"][0].erase("camera_from_world"); }),
              HasSubstr("between[0] has no 'camera_from_world'"));
  EXPECT_THAT(fault([](json& j) {
                j["frames"][1]["frame"] = 2, j["between"].erase(1);
                j["frames"].push_back(j["frames"][1]), j["frames"][2]["frame"] = 4;
                j["between"][0]["frame"] = 2;
              }),
              HasSubstr("has a camera of its own"));
}

TEST(ShotFile, OneFocalLengthStandsForBoth) {
  json root = json::parse(ShotText(SomeShot()));
  root["camera"].erase("fx"), root["camera"].erase("fy"), root["camera"]["f"] = 1234.5;
  const FilmedShot shot = ParseShot(root.dump(), "shot.json");
  EXPECT_EQ(shot.camera.fx, 1234.5);
  EXPECT_EQ(shot.camera.fy, 1234.5);
}

TEST(ShotFile, FaultsNameFrameAndField) {
  EXPECT_THAT(FaultOf([](json& j) { j["frames"][1].erase("picture"); }),
              HasSubstr("shot.json: frames[1] has no 'picture'"));
  EXPECT_THAT(FaultOf([](json& j) { j["frames"][1]["method"] = "outline"; }),
              HasSubstr("did you mean \"outlines\"?"));
  EXPECT_THAT(FaultOf([](json& j) {
                j["frames"][0]["camera_from_world"]["rotation"] = {1, 1, 0, 0};
              }),
              HasSubstr("frames[0]: 'camera_from_world' has a 'rotation' of length 1.41421"));
  EXPECT_THAT(FaultOf([](json& j) { j["frames"][0]["world_from_character"]["scale"] = -1; }),
              HasSubstr("'scale' -1"));
  EXPECT_THAT(FaultOf([](json& j) { j["frames"][1]["frame"] = 0; }),
              HasSubstr("frame 0 comes after frame 0"));
  EXPECT_THAT(FaultOf([](json& j) { j["frames"] = json::array(); }), HasSubstr("has no frames"));
  EXPECT_THAT(FaultOf([](json& j) { j["frames"][1]["camera_from_world"]["translation"][2] = 2; }),
              HasSubstr("'still' is true"));
  EXPECT_THAT(FaultOf([](json& j) { j["camera"]["fx"] = 0; }), HasSubstr("'fx' 0"));
  EXPECT_THAT(FaultOf([](json& j) { j["schema"] = 2; }), HasSubstr("schema 2"));
  EXPECT_THAT(FaultOf([](json& j) { j["width"] = "wide"; }), HasSubstr("'width'"));
  EXPECT_THAT(FaultOf([](json& j) { j["frames"][0]["picture"] = "../a.png"; }),
              HasSubstr("'picture'"));
  EXPECT_THROW(ParseShot("{\"schema\": 1, ", "shot.json"), InputError);
  EXPECT_THROW(ParseShot("[1]", "shot.json"), InputError);
}

class FilmFolder : public ::testing::Test, public TestingFolder {
 protected:
  void Touch(const std::string& name) { std::ofstream(folder_ / name) << "x"; }
  std::string Fault() {
    try {
      FilmPictures(folder_);
    } catch (const InputError& error) {
      return error.what();
    }
    return "none";
  }
};

TEST_F(FilmFolder, NumbersAreTimesFromTheFirstPicture) {
  for (const char* name :
       {"take2_0110.png", "take2_0102.JPG", "take2_0099.png", "notes.txt", ".hidden_0103.png"})
    Touch(name);
  fs::create_directories(folder_ / "masks0104.png");
  const std::vector<FilmPicture> pictures = FilmPictures(folder_);
  ASSERT_EQ(pictures.size(), 3u);
  EXPECT_EQ(pictures[0].frame, 0);
  EXPECT_EQ(pictures[1].frame, 3);
  EXPECT_EQ(pictures[2].frame, 11);
  EXPECT_EQ(pictures[1].path.filename(), "take2_0102.JPG");
  EXPECT_EQ(pictures[1].number, 102);
  const std::vector<FilmPicture> one = FilmPictures(folder_ / "take2_0110.png");
  ASSERT_EQ(one.size(), 1u);
  EXPECT_EQ(one[0].frame, 0);
}

TEST_F(FilmFolder, PicturesOfCompositingProgramsAreCalledWhatTheyAre) {
  Touch("film.1001.exr"), Touch("film.1002.EXR"), Touch("notes.txt");
  EXPECT_THAT(Fault(), HasSubstr("but 2 .exr files"));
  EXPECT_THAT(Fault(), HasSubstr("oiiotool"));
  const std::vector<FilmPicture> light = FilmPictures(folder_, FilmKinds::kPicturesOrLight);
  ASSERT_EQ(light.size(), 2u);
  EXPECT_EQ(light[1].number, 1002);
  Touch("film.1001.png");
  EXPECT_EQ(FilmPictures(folder_, FilmKinds::kPicturesOrLight).size(), 1u) << "proxies come first";
}

TEST_F(FilmFolder, OfSeveralCamerasFilmsAreListedByNumber) {
  for (const char* name : {"cam10", "cam2", "masks", "background", "notes", ".trash"})
    fs::create_directories(folder_ / name);
  for (const char* name :
       {"cam10/2.jpg", "cam10/10.png", "cam10/.x.jpg", "cam10/a.txt", "cam2/000.TIF", "masks/1.png",
        "background/cam2.jpg", "notes/a.txt", ".trash/1.jpg", "cam1.MP4", "rig.yml"})
    Touch(name);
  const std::vector<CameraFilm> films = CameraFilms(folder_);
  ASSERT_EQ(films.size(), 3u);
  EXPECT_EQ(films[0].name, "cam1");
  EXPECT_EQ(films[0].video, folder_ / "cam1.MP4");
  EXPECT_EQ(films[1].name, "cam2");
  EXPECT_EQ(films[2].name, "cam10");
  EXPECT_TRUE(films[2].video.empty());
  EXPECT_EQ(films[2].pictures,
            (std::vector<fs::path>{folder_ / "cam10/2.jpg", folder_ / "cam10/10.png"}));
  EXPECT_TRUE(CameraFilms(folder_ / "nothing").empty());
  Touch("cam2.mov");
  EXPECT_THROW(CameraFilms(folder_), InputError);
}

TEST_F(FilmFolder, WhatCannotBeNumberedIsRefused) {
  EXPECT_THAT(Fault(), HasSubstr("has no pictures"));
  Touch("a_01.png"), Touch("b_1.jpg");
  EXPECT_THAT(Fault(), HasSubstr("have the same frame number 1"));
  fs::remove(folder_ / "b_1.jpg");
  Touch("plate.png");
  EXPECT_THAT(Fault(), HasSubstr("the picture plate has no frame number"));
  EXPECT_THROW(FilmPictures(folder_ / "nothing"), InputError);
}

}  // namespace keypose::shot_io_test
