#include <gtest/gtest.h>

#include "core/io/pictures/image_io.h"
#include "core/io/pictures/image_set.h"
#include "core/io/pictures/png_io.h"
#include "core/io/project/colmap_io.h"
#include "core/io/project/poses_io.h"
#include "core/io/text/files.h"
#include "core/testing/folder.h"
#include "core/values/errors.h"

namespace keypose::io_test {

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

class Files : public ::testing::Test, public TestingFolder {};

TEST_F(Files, FullDiskGivesDiskErrorAndNoFile) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "no /dev/full here";
  EXPECT_THROW(WriteFile("/dev/full", std::string(1 << 20, 'x')), DiskError);
}

TEST_F(Files, MaskOfOneBitAPixelComesBack) {
  for (const int width : {1, 8, 13}) {
    Image8 mask(width, 5, 1), expected(width, 5, 1);
    for (std::size_t i = 0; i < mask.data.size(); ++i) {
      mask.data[i] = i % 3 == 0 ? 128 : i % 5 == 0 ? 255 : 127;
      expected.data[i] = mask.data[i] > 127 ? 255 : 0;
    }
    WriteMaskPng(folder_ / "mask.png", mask);
    EXPECT_EQ(ReadImage(folder_ / "mask.png", 1).data, expected.data) << width;
  }
  EXPECT_EQ(ReadFile(folder_ / "mask.png").at(24), 1) << "bits of a pixel";
}

TEST(NearestWord, FindsTheTypo) {
  EXPECT_EQ(NearestWord("facse", {"alpha", "faces", "offset"}), "faces");
}

class PosesIo : public ::testing::Test, public TestingFolder {};

TEST_F(PosesIo, TransformsAreCameraToWorldWithYUp) {
  // A camera at (0, -2, 0) that looks along +y, z up.
  const fs::path file =
      Put("transforms.json", R"({"fl_x": 900, "w": 640, "h": 480, "k1": 0.01, "frames": [
    {"file_path": "./images/b.jpg", "transform_matrix": [[1, 0, 0, 0], [0, 0, -1, -2], [0, 1, 0, 0], [0, 0, 0, 1]]},
    {"file_path": "./images/a", "cx": 300, "transform_matrix": [[1, 0, 0, 0], [0, 0, -1, -2], [0, 1, 0, 0]]}]})");
  const std::vector<View> views = ReadPoses(file);
  ASSERT_EQ(views.size(), 2u);
  EXPECT_EQ(ReadPoses(file.parent_path()).size(), 2u) << "the file is found in its folder";
  EXPECT_EQ(views[0].name, "a");
  EXPECT_EQ(views[0].camera.cx, 300);
  EXPECT_EQ(views[1].camera.fy, 900);
  EXPECT_EQ(views[1].camera.k1, 0.01);
  EXPECT_LT((views[1].Center() - Eigen::Vector3d(0, -2, 0)).norm(), 1e-12);
  // A point in front of the camera, to the right and above, projects to the right of and above the
  // centre.
  const Eigen::Vector3d seen = views[1].camera_from_world * Eigen::Vector3d(0.1, 0, 0.2);
  EXPECT_LT((seen - Eigen::Vector3d(0.1, -0.2, 2)).norm(), 1e-12);
}

TEST_F(PosesIo, FaultsAreInputErrorsThatNameTheFrame) {
  const auto message = [&](const std::string& text) -> std::string {
    try {
      ReadPoses(Put("transforms.json", text));
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_NE(message("{").find("transforms.json"), std::string::npos);
  EXPECT_NE(message(R"({"frames": []})").find("holds no camera"), std::string::npos);
  EXPECT_NE(message(R"({"fl_x": 9, "frames": [{"file_path": "q.jpg",
    "transform_matrix": [[2, 0, 0, 0], [0, 2, 0, 0], [0, 0, 2, 0], [0, 0, 0, 1]]}]})")
                .find("frame q.jpg"),
            std::string::npos);
  EXPECT_NE(
      message(
          R"({"frames": [{"file_path": "q.jpg", "transform_matrix": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]]}]})")
          .find("no focal length"),
      std::string::npos);
  EXPECT_THROW(ReadPoses(Put("poses.csv", "a")), InputError);
}

class ImageSetIo : public ::testing::Test, public TestingFolder {};

TEST_F(ImageSetIo, PlateAndGroupsComeBackAsTheyWereWritten) {
  ImageSet set;
  set.folder = folder_;
  set.board = BoardLayout{9, 7, 0.030, 0.02};
  CapturedImage image;
  image.name = "a.jpg";
  image.group = "lying";
  image.photograph_width = 4000;
  image.photograph_height = 3000;
  image.board_corners = {{0, Eigen::Vector2d(1.25, 1.0 / 3)}, {47, Eigen::Vector2d(-2, 1e3)}};
  set.images = {image};
  WriteFile(folder_ / "a.jpg", "x");
  WriteImageSet(set);
  const ImageSet read = ReadImageSet(folder_);
  ASSERT_TRUE(read.board.has_value());
  EXPECT_EQ(read.board->columns, 9);
  EXPECT_EQ(read.board->marker_m, 0.02);
  EXPECT_EQ(read.images[0].group, "lying");
  EXPECT_EQ(read.images[0].photograph_width, 4000);
  EXPECT_EQ(read.images[0].photograph_height, 3000);
  ASSERT_EQ(read.images[0].board_corners.size(), 2u);
  EXPECT_EQ(read.images[0].board_corners[1].id, 47);
  EXPECT_EQ(read.images[0].board_corners[0].pixel, image.board_corners[0].pixel);
}

TEST_F(ImageSetIo, PlateCornerThatThePlateDoesNotHaveIsAnInputError) {
  ImageSet set;
  set.folder = folder_;
  set.board = BoardLayout{3, 3, 0.030, 0.02};
  CapturedImage image;
  image.name = "a.jpg";
  image.board_corners = {{4, Eigen::Vector2d::Zero()}};
  set.images = {image};
  WriteFile(folder_ / "a.jpg", "x");
  WriteImageSet(set);
  EXPECT_THROW(ReadImageSet(folder_), InputError);
}

TEST(BoardLayout, CornersAreCentredAndRunFromTheTopLeft) {
  const BoardLayout board;
  ASSERT_EQ(board.CornerCount(), 70);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int id = 0; id < board.CornerCount(); ++id) sum += board.Corner(id);
  EXPECT_LT(sum.norm(), 1e-14);
  EXPECT_LT((board.Corner(0) - Eigen::Vector3d(-4.5 * 0.022, 3 * 0.022, 0)).norm(), 1e-15);
  EXPECT_LT((board.Corner(1) - board.Corner(0) - Eigen::Vector3d(0.022, 0, 0)).norm(), 1e-15);
  EXPECT_TRUE(board.Problems().empty());
  EXPECT_FALSE((BoardLayout{15, 15, 0.02, 0.015}.Problems().empty()));
  EXPECT_FALSE((BoardLayout{11, 8, 0.02, 0.02}.Problems().empty()));
}

}  // namespace keypose::io_test
