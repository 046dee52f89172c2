#include "core/io/project/colmap_write.h"

#include <gtest/gtest.h>

#include "core/io/project/colmap_io.h"
#include "core/io/text/files.h"
#include "core/testing/folder.h"

namespace keypose::colmap_write_test {

Scene TwoViews() {
  Scene scene;
  for (const char* name : {"a.jpg", "b.jpg"}) {
    View view;
    view.name = name;
    view.camera = {640, 480, 500, 501, 320, 240, 0, 0, 0, 0};
    view.camera_from_world = {Eigen::Quaterniond(1, 0.1, 0.2, name[0] * 0.01).normalized(),
                              {0, 0.1, 3}};
    scene.views.push_back(view);
  }
  scene.views[1].camera.k1 = 1.0 / 3;
  for (const std::vector<int>& seen : {std::vector<int>{1}, {0, 1}}) {
    SparsePoint point;
    point.position = {0.1, 0.2, 1.0 / 7};
    point.color << 10, 20, 30;
    point.error_px = 0.5;
    point.views = seen;
    scene.points.push_back(point);
  }
  return scene;
}

TEST(WriteColmapForOthers, TextAndBinaryAreTheSameModel) {
  const TestingFolder folder;
  const Scene scene = TwoViews();
  WriteColmapForOthers(folder.path(), scene);
  const Scene binary = ReadColmapModel(folder.path());
  for (const char* file : {"cameras.bin", "images.bin", "points3D.bin"})
    fs::remove(folder.path() / file);
  const Scene text = ReadColmapModel(folder.path());
  for (const Scene* read : {&binary, &text}) {
    ASSERT_EQ(read->views.size(), 2u);
    ASSERT_EQ(read->points.size(), 2u);
    EXPECT_EQ(read->views[1].camera.k1, 1.0 / 3);
    EXPECT_EQ(read->views[0].camera_from_world.translation, Eigen::Vector3d(0, 0.1, 3));
    EXPECT_EQ(read->points[1].position, scene.points[1].position);
    EXPECT_EQ(read->points[1].views, scene.points[1].views);
  }
}

TEST(WriteColmapForOthers, CamerasWithoutDistortionArePinholes) {
  const TestingFolder folder;
  WriteColmapForOthers(folder.path(), TwoViews());
  const std::string text = ReadFile(folder.path() / "cameras.txt");
  EXPECT_NE(text.find("1 PINHOLE 640 480 500 501 320 240\n"), std::string::npos) << text;
  EXPECT_NE(text.find("2 OPENCV 640 480 500 501 320 240 0.3333333333333333 0 0 0\n"),
            std::string::npos);
}

TEST(WriteColmapForOthers, FeaturesAreCountedInEachImage) {
  const TestingFolder folder;
  WriteColmapForOthers(folder.path(), TwoViews());
  const std::string text = ReadFile(folder.path() / "points3D.txt");
  EXPECT_NE(text.find(" 0.5 2 0\n2 "), std::string::npos) << text;
  EXPECT_NE(text.find(" 0.5 1 0 2 1\n"), std::string::npos) << text;
}

TEST(WriteColmapForOthers, NamesWithSpacesHaveNoText) {
  const TestingFolder folder;
  Scene scene = TwoViews();
  scene.views[0].name = "a b.jpg";
  WriteColmapForOthers(folder.path(), scene);
  EXPECT_FALSE(fs::exists(folder.path() / "images.txt"));
  EXPECT_EQ(ReadColmapModel(folder.path()).views[0].name, "a b.jpg");
}

}  // namespace keypose::colmap_write_test
