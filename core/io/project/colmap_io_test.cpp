#include "core/io/project/colmap_io.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>

#include "core/io/testing/damaged_file.h"
#include "core/io/text/files.h"
#include "core/testing/folder.h"
#include "core/testing/paths.h"
#include "core/values/errors.h"

namespace keypose::colmap_io_test {

namespace fs = std::filesystem;

std::string CamerasText(const std::string& camera) { return "1 OPENCV " + camera + "\n"; }

TEST_F(HostileModel, CamerasAndPosesThatCannotBeAreInputErrors) {
  const std::string good_camera = "640 480 500 500 320 240 0 0 0 0", good_pose = "1 0 0 0 0 0 3";
  const auto model = [&](const std::string& camera, const std::string& pose,
                         const std::string& point) {
    Put("cameras.txt", CamerasText(camera));
    Put("images.txt", "1 " + pose + " 1 a.jpg\n\n");
    Put("points3D.txt", "1 " + point + " 9 9 9 0.5 1 0\n");
    return folder_;
  };
  EXPECT_EQ(ReadColmapModel(model(good_camera, good_pose, "0 0 0")).views.size(), 1u);
  for (const char* bad : {"640 480 0 500 320 240 0 0 0 0", "640 480 1e300 500 320 240 0 0 0 0",
                          "640 480 500 500 320 240 1e30 0 0 0", "0 480 500 500 320 240 0 0 0 0",
                          "4294967297 480 500 500 320 240 0 0 0 0",
                          "60000 60000 500 500 320 240 0 0 0 0", "640 480 -500 500 320 240 0 0 0 0",
                          "640 480 500 1e-300 320 240 0 0 0 0", "640 480 nan 500 320 240 0 0 0 0"})
    Message<InputError>("cameras.txt", [&] { ReadColmapModel(model(bad, good_pose, "0 0 0")); });
  for (const char* bad :
       {"0 0 0 0 0 0 3", "1 0 0 0 0 0 1e200", "nan 0 0 0 0 0 3", "1e200 0 0 0 0 0 3"})
    Message<InputError>("images.txt", [&] { ReadColmapModel(model(good_camera, bad, "0 0 0")); });
  Message<InputError>("points3D.txt",
                      [&] { ReadColmapModel(model(good_camera, good_pose, "0 1e99 0")); });
}

TEST_F(HostileModel, NumbersThatAreNotFiniteInBinaryModelsAreInputErrors) {
  Scene scene;
  View view;
  view.name = "a.jpg";
  view.camera = {640, 480, 500, 500, 320, 240, 0, 0, 0, 0};
  scene.views = {view};
  const auto spoilt = [&](const std::function<void(View&)>& spoil) {
    Scene bad = scene;
    spoil(bad.views[0]);
    WriteColmapModel(folder_, bad);
    return folder_;
  };
  Message<InputError>("cameras.bin",
                      [&] { ReadColmapModel(spoilt([](View& v) { v.camera.k1 = NAN; })); });
  Message<InputError>("cameras.bin",
                      [&] { ReadColmapModel(spoilt([](View& v) { v.camera.fy = INFINITY; })); });
  Message<InputError>("images.bin", [&] {
    ReadColmapModel(spoilt([](View& v) { v.camera_from_world.translation.x() = NAN; }));
  });
  Message<InputError>("images.bin", [&] {
    ReadColmapModel(spoilt([](View& v) { v.camera_from_world.rotation.coeffs().setZero(); }));
  });
}

class ColmapIo : public ::testing::Test, public TestingFolder {};

Scene SmallScene() {
  Scene scene;
  for (const char* name : {"a.jpg", "b.jpg"}) {
    View view;
    view.name = name;
    view.camera = {640, 480, 500, 501, 320, 240, 0.01, -0.02, 1e-4, 2e-4};
    view.camera_from_world = {Eigen::Quaterniond(1, 0.1, 0.2, name[0] * 0.01).normalized(),
                              {0, 0.1, 3}};
    scene.views.push_back(view);
  }
  SparsePoint point;
  point.position = {0.1, 0.2, 0.3};
  point.color << 10, 20, 30;
  point.error_px = 0.5;
  point.views = {0, 1};
  scene.points.push_back(point);
  return scene;
}

TEST_F(ColmapIo, BinaryModelComesBack) {
  const Scene scene = SmallScene();
  WriteColmapModel(folder_, scene);
  const Scene read = ReadColmapModel(folder_);
  ASSERT_EQ(read.views.size(), 2u);
  for (int v = 0; v < 2; ++v) {
    EXPECT_LT((read.views[v].Project({0.1, 0, 0.2}) - scene.views[v].Project({0.1, 0, 0.2})).norm(),
              1e-9);
    EXPECT_EQ(read.views[v].name, scene.views[v].name);
  }
  ASSERT_EQ(read.points.size(), 1u);
  EXPECT_EQ(read.points[0].views, scene.points[0].views);
  EXPECT_EQ(read.points[0].position, scene.points[0].position);
}

TEST_F(ColmapIo, TruncatedModelThrowsInputError) {
  WriteColmapModel(folder_, SmallScene());
  const std::string bytes = ReadFile(folder_ / "images.bin");
  Put("images.bin", bytes.substr(0, bytes.size() - 9));
  EXPECT_THROW(ReadColmapModel(folder_), InputError);
  EXPECT_THROW(ReadColmapModel(folder_ / "absent"), InputError);
}

// What COLMAP 3.8 to 4.2 read of its own text (ReadImagesText), and what people's scripts write.
TEST_F(ColmapIo, EveryTextThatColmapReadsIsTheSameModel) {
  const std::string cameras = "1 PINHOLE 640 480 500 501 320 240\n";
  const std::string first = "1 1 0 0 0 0 0 3 1 IMG 00.jpg\n", features = "10.5 20.5 -1 30 40 7\n",
                    second = "2 1 0 0 0 1 0 3 1 IMG 01.jpg\n",
                    head = "# Image list\n#   IMAGE_ID, ...\n";
  const auto crlf = [](std::string text) {
    for (std::size_t at = 0; (at = text.find('\n', at)) != std::string::npos; at += 2)
      text.replace(at, 1, "\r\n");
    return text;
  };
  for (const auto& [what, images] : std::vector<std::pair<std::string, std::string>>{
           {"plain", head + first + "\n" + second + "\n"},
           {"empty first line", "\n" + head + first + "\n" + second + "\n"},
           {"empty lines between", head + "\n\n" + first + "\n\n\n" + second + "\n\n\n"},
           {"features", first + features + second + features},
           {"features and empty lines", "\n" + first + features + "\n" + second + "\n"},
           {"comments between", first + "\n# next\n" + second + "\n"},
           {"no line of features at the end", first + "\n" + second},
           {"no lines of features", first + second},
           {"carriage returns", crlf("\n" + head + first + features + second + "\n")},
           {"byte order mark", "\xEF\xBB\xBF" + first + "\n" + second + "\n"},
           {"spaces at the ends", "  " + first + " \n\t" + second + "\n"}}) {
    Put("cameras.txt",
        what == "carriage returns" ? crlf("# Cameras\n\n" + cameras) : "\n" + cameras);
    Put("images.txt", images);
    const Scene scene = ReadColmapModel(folder_);
    ASSERT_EQ(scene.views.size(), 2u) << what;
    EXPECT_EQ(scene.views[0].name, "IMG 00.jpg") << what;
    EXPECT_EQ(scene.views[1].name, "IMG 01.jpg") << what;
    EXPECT_EQ(scene.views[1].Center(), Eigen::Vector3d(-1, 0, -3)) << what;
  }
}

TEST_F(ColmapIo, EqualNamesInSubfoldersAreTwoViews) {
  Put("cameras.txt", "1 PINHOLE 640 480 500 501 320 240\n2 PINHOLE 640 480 700 700 320 240\n");
  Put("images.txt", "1 1 0 0 0 0 0 3 1 left/1.jpg\n\n2 1 0 0 0 1 0 3 2 right/1.jpg\n\n");
  Put("points3D.txt", "# nothing\n\n1 0.1 0.2 0.3 10 20 30 0.5 1 0 2 0\r\n");
  for (const char* beside : {"rigs.bin", "frames.bin", "project.ini"})
    Put(beside, "of newer versions");
  const Scene scene = ReadColmapModel(folder_);
  ASSERT_EQ(scene.views.size(), 2u);
  EXPECT_EQ(scene.views[0].name, "left/1.jpg");
  EXPECT_EQ(scene.views[1].camera.fx, 700);
  ASSERT_EQ(scene.points.size(), 1u);
  EXPECT_EQ(scene.points[0].views, (std::vector<int>{0, 1}));
}

TEST_F(ColmapIo, TheOneModelBelowIsFound) {
  const Scene scene = SmallScene();
  fs::create_directories(folder_ / "sparse/0");
  WriteColmapModel(folder_ / "sparse/0", scene);
  EXPECT_TRUE(HasColmapModel(folder_));
  EXPECT_EQ(ReadColmapModel(folder_).views.size(), 2u);
  fs::create_directories(folder_ / "sparse/1");
  WriteColmapModel(folder_ / "sparse/1", scene);
  EXPECT_THROW(ReadColmapModel(folder_), InputError);
  EXPECT_FALSE(HasColmapModel(folder_ / "absent"));
}

TEST_F(ColmapIo, LensesThatNoCameraHoldsAreNamed) {
  const auto fault = [&](const std::string& camera) {
    Put("cameras.txt", camera + "\n3 EQUIRECTANGULAR 640 480\n");
    Put("images.txt", "1 1 0 0 0 0 0 3 1 a.jpg\n\n");
    try {
      ReadColmapModel(folder_);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("none");
  };
  EXPECT_NE(fault("1 OPENCV_FISHEYE 640 480 200 200 320 240 0 0 0 0").find("EQUIRECTANGULAR"),
            std::string::npos);
  Put("cameras.txt", "1 OPENCV_FISHEYE 640 480 200 200 320 240 0.01 0 0 0\n");
  try {
    ReadColmapModel(folder_);
    FAIL();
  } catch (const InputError& error) {
    const std::string what = error.what();
    EXPECT_NE(what.find("camera 1: its lens model OPENCV_FISHEYE"), std::string::npos) << what;
    EXPECT_NE(what.find("colmap image_undistorter"), std::string::npos) << what;
  }
  EXPECT_EQ(ReadColmapLenses(folder_).at(0).lens.radial[0], 0.01);
  Put("cameras.txt", "1 NEW_MODEL 640 480 200 200\n");
  EXPECT_THROW(ReadColmapModel(folder_), InputError);
  Put("cameras.txt", "1 PINHOLE 640 480 200 200 320 240 0.1\n");
  EXPECT_THROW(ReadColmapModel(folder_), InputError) << "one number too many";
}

TEST_F(ColmapIo, NumbersOfNewerModelsAreRefused) {
  WriteColmapModel(folder_, SmallScene());
  std::string bytes = ReadFile(folder_ / "cameras.bin");
  bytes[12] = 77;
  Put("cameras.bin", bytes);
  try {
    ReadColmapModel(folder_);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("newer than COLMAP 4.2"), std::string::npos);
  }
}

TEST_F(ColmapIo, ReportedModelsAreReadRight) {
  const fs::path reports = DataFolder() / "reports";
  if (!fs::exists(reports)) GTEST_SKIP() << reports << " is not there";
  const auto truth = nlohmann::json::parse(ReadFile(reports / "16_colmap_text/truth.json"));
  for (const char* name : {"plain", "blank_first_line"}) {
    const Scene scene = ReadColmapModel(reports / "16_colmap_text" / name);
    ASSERT_EQ(scene.views.size(), truth.size());
    for (std::size_t i = 0; i < truth.size(); ++i) {
      const auto& c = truth[i]["center"];
      EXPECT_EQ(scene.views[i].name, truth[i]["name"]);
      EXPECT_LT((scene.views[i].Center() - Eigen::Vector3d(c[0], c[1], c[2])).norm(), 1e-6);
    }
  }
  const Camera camera =
      ReadColmapModel(reports / "17_colmap_models/OPENCV_FISHEYE").views[0].camera;
  const Lens lens = ReadColmapLenses(reports / "17_colmap_models/OPENCV_FISHEYE")[0].lens;
  for (const double x : {-0.35, 0.0, 0.3})
    for (const double y : {-0.25, 0.1, 0.28})
      EXPECT_LT((camera.Project({x, y, 1}) - *lens.Project({x, y, 1})).norm(), kSameLens_px);
  EXPECT_EQ(lens.radial, (std::array<double, 6>{0.05, -0.02, 0.01, 0.002, 0, 0}));
  EXPECT_EQ(ReadColmapModel(reports / "17_colmap_models/OPENCV").views[0].camera.k1, -0.1);
}

}  // namespace keypose::colmap_io_test
