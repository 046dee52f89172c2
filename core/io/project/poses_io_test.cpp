#include "core/io/project/poses_io.h"

#include <gtest/gtest.h>

#include <array>

#include "core/io/testing/damaged_file.h"
#include "core/testing/folder.h"
#include "core/values/errors.h"

namespace keypose::poses_io_test {

namespace fs = std::filesystem;

TEST_F(HostileModel, TransformsWithCamerasThatCannotBeAreInputErrors) {
  const auto file = [&](const std::string& camera, const std::string& x = "0") {
    return Put("transforms.json",
               "{" + camera +
                   R"(, "frames": [{"file_path": "a.jpg", "transform_matrix": [[1,0,0,)" + x +
                   "],[0,1,0,0],[0,0,1,0],[0,0,0,1]]}]}");
  };
  EXPECT_EQ(ReadPoses(file(R"("fl_x": 900, "w": 640, "h": 480)")).size(), 1u);
  for (const char* bad :
       {R"("fl_x": 900, "w": 1e300, "h": 480)", R"("fl_x": 900, "w": -5, "h": 480)",
        R"("fl_x": 1e300, "w": 640, "h": 480)"})
    Message<InputError>("transforms.json", [&] { ReadPoses(file(bad)); });
  Message<InputError>("transforms.json",
                      [&] { ReadPoses(file(R"("fl_x": 900, "w": 640, "h": 480)", "1e200")); });
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

TEST_F(PosesIo, CamerasOfOtherProgramsAreRefusedByTheirNames) {
  const std::vector<std::array<std::string, 3>> files{
      {"reconstruction.json", R"([{"cameras": {}, "shots": {}}])", "OpenSfM"},
      {"bundle.out", "# Bundle file v0.3\n1 0\n", "Bundler"},
      {"a.nvm", "NVM_V3\n\n1\n", "VisualSFM"},
      {"a.csv", "#name,x,y,alt,heading,pitch,roll\n", "RealityCapture"},
      {"cameras.sfm", R"({"version": ["1"], "featuresFolders": [""], "views": []})", "Meshroom"},
      {"sfm_data.json", R"({"sfm_data_version": "0.3", "views": []})", "OpenMVG"}};
  for (const auto& [name, text, program] : files) try {
      ReadPoses(Put(name, text));
      ADD_FAILURE() << name;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find("has cameras of " + program), std::string::npos)
          << error.what();
    }
}

}  // namespace keypose::poses_io_test
