#include "core/io/project/colmap_io.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "core/io/testing/damaged_file.h"
#include "core/io/text/files.h"
#include "core/testing/folder.h"
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

}  // namespace keypose::colmap_io_test
