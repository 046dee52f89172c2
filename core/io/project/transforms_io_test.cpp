#include "core/io/project/transforms_io.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/io/project/poses_io.h"
#include "core/testing/folder.h"
#include "core/testing/paths.h"
#include "core/values/errors.h"

namespace keypose::transforms_io_test {

class Transforms : public ::testing::Test, public TestingFolder {
 protected:
  /// A file of one frame with these words of the file and of the frame.
  fs::path File(const std::string& root, const std::string& frame = "") const {
    return Put("transforms.json",
               "{" + root + (root.empty() ? "" : ", ") + R"("frames": [{"file_path": "a.jpg")" +
                   (frame.empty() ? "" : ", ") + frame +
                   R"(, "transform_matrix": [[1,0,0,0],[0,1,0,0],[0,0,1,0]]}]})");
  }
  Lens LensOf(const std::string& root, const std::string& frame = "") const {
    return ReadTransforms(File(root, frame)).at(0).lens;
  }
  std::string Fault(const std::string& root, const std::string& frame = "") const {
    try {
      ReadTransforms(File(root, frame));
    } catch (const InputError& error) {
      return error.what();
    }
    return "none";
  }
};

const std::string kSize = R"("w": 400, "h": 300)";

TEST_F(Transforms, FocalLengthsComeFromAnyOfTheirNames) {
  EXPECT_EQ(LensOf(kSize + R"(, "fl_x": 500)").fy, 500);
  EXPECT_EQ(LensOf(kSize + R"(, "fl_x": 500, "fl_y": 510)").fy, 510);
  EXPECT_NEAR(LensOf(kSize + R"(, "camera_angle_x": 0.8)").fx, 200 / std::tan(0.4), 1e-9);
  EXPECT_NEAR(LensOf(kSize + R"(, "camera_angle_x": 0.8, "camera_angle_y": 0.6)").fy,
              150 / std::tan(0.3), 1e-9);
  EXPECT_NEAR(LensOf(kSize + R"(, "camera_angle_y": 0.6)").fx, 150 / std::tan(0.3), 1e-9);
  EXPECT_NEAR(LensOf(kSize + R"(, "x_fov": 60)").fx, 200 / std::tan(M_PI / 6), 1e-9);
  EXPECT_NEAR(LensOf(R"("camera_angle_x": 0.8)").fx, -1 / (2 * std::tan(0.4)), 1e-12);
  EXPECT_NE(Fault(kSize).find("frame a.jpg has no focal length"), std::string::npos);
}

TEST_F(Transforms, AFramesOwnNumbersCount) {
  const Lens lens =
      LensOf(kSize + R"(, "fl_x": 500, "cx": 190, "k1": 0.1, "camera_model": "PINHOLE")",
             R"("fl_x": 600, "cx": 210, "k1": 0.2, "h": 310)");
  EXPECT_EQ(lens.fx, 600);
  EXPECT_EQ(lens.cx, 210);
  EXPECT_EQ(lens.radial[0], 0.2);
  EXPECT_EQ(lens.height, 310);
  EXPECT_EQ(lens.cy, 155);
  EXPECT_NEAR(LensOf(kSize + R"(, "fl_x": 500)", R"("camera_angle_x": 0.8)").fx,
              200 / std::tan(0.4), 1e-9);
}

// nerfstudio's list stands for the six names; a name counts before it.
TEST_F(Transforms, ListedCoefficientsAreRead) {
  const std::string root =
      kSize + R"(, "fl_x": 500, "distortion_params": [0.1, 0.02, 0, 0, 0.003, 0.004])";
  const Lens lens = LensOf(root);
  EXPECT_EQ(lens.radial[0], 0.1);
  EXPECT_EQ(lens.radial[1], 0.02);
  EXPECT_EQ(lens.p1, 0.003);
  EXPECT_EQ(lens.p2, 0.004);
  EXPECT_EQ(LensOf(root, R"("distortion_params": [0.3])").radial[0], 0.3);
  EXPECT_EQ(LensOf(root, R"("distortion_params": [0.3])").radial[1], 0.02);
  EXPECT_EQ(LensOf(root + R"(, "k1": 0.5)").radial[0], 0.5);
  EXPECT_NE(Fault(kSize + R"(, "fl_x": 500, "distortion_params": [0,0,0,0,0,0,1])")
                .find("k1 k2 k3 k4 p1 p2"),
            std::string::npos);
}

TEST_F(Transforms, AnglesOfNoPictureAreRefused) {
  EXPECT_NE(Fault(kSize + R"(, "camera_angle_x": 39.6)").find("in radians"), std::string::npos);
  EXPECT_NE(Fault(kSize + R"(, "x_fov": 180)").find("in degrees"), std::string::npos);
  EXPECT_NE(Fault(kSize + R"(, "fl_x": 500, "orthographic": true)").find("orthographic"),
            std::string::npos);
}

TEST_F(Transforms, AFrameWithoutAPlaceIsNamed) {
  const std::string root = R"("w": 400, "h": 300, "fl_x": 500, "frames": [{"file_path": "a.jpg")";
  const auto fault = [&](const std::string& matrix) -> std::string {
    try {
      ReadTransforms(Put("transforms.json", "{" + root + matrix + "}]}"));
    } catch (const InputError& error) {
      return error.what();
    }
    return "none";
  };
  EXPECT_NE(fault("").find("frame a.jpg has no transform_matrix"), std::string::npos);
  EXPECT_NE(fault(R"(, "transform_matrix": [[-1,0,0,0],[0,1,0,0],[0,0,1,0]])").find("mirrors"),
            std::string::npos);
}

// Every value of `camera_model` of nerfstudio 1.1 and the flags of instant-ngp.
TEST_F(Transforms, EveryModelIsReadOrRefusedByName) {
  const std::string four = kSize + R"(, "fl_x": 300, "k1": 0.1, "k2": 0.2, "k3": 0.3, "k4": 0.4)";
  const auto with_model = [&](const std::string& name) {
    return four + R"(, "camera_model": ")" + name + "\"";
  };
  using enum LensProjection;
  for (const char* plain : {"OPENCV", "PINHOLE", "SIMPLE_PINHOLE", "perspective"}) {
    const Lens lens = LensOf(with_model(plain));
    EXPECT_EQ(lens.projection, kPerspective) << plain;
    EXPECT_EQ(lens.radial, (std::array<double, 6>{0.1, 0.2, 0.3, 0.4, 0, 0})) << plain;
  }
  for (const char* fisheye : {"OPENCV_FISHEYE", "fisheye"})
    EXPECT_EQ(LensOf(with_model(fisheye)).projection, kEquidistant) << fisheye;
  EXPECT_EQ(LensOf(four + R"(, "is_fisheye": true)").projection, kEquidistant);
  EXPECT_EQ(LensOf(four, R"("is_fisheye": true)").projection, kEquidistant);
  EXPECT_EQ(LensOf(four + R"(, "is_fisheye": false)").projection, kPerspective);
  EXPECT_EQ(LensOf(with_model("FULL_OPENCV")).divisor[0], 0.4);
  for (const char* other : {"EQUIRECTANGULAR", "OMNIDIRECTIONALSTEREO_L", "OMNIDIRECTIONALSTEREO_R",
                            "VR180_L", "VR180_R", "ORTHOPHOTO", "FISHEYE624", "SOMETHING_NEW"})
    EXPECT_NE(Fault(with_model(other)).find(std::string("a.jpg: the lens model ") + other),
              std::string::npos)
        << Fault(with_model(other));
  for (const char* flag : {R"("from_na": true)", R"("from_mitsuba": true)", R"("latlong": true)",
                           R"("equirectangular": true)", R"("ftheta_p0": 0.1)",
                           R"("rolling_shutter": [0, 0, 0.02, 0])"}) {
    const std::string name = std::string(flag).substr(1, std::string(flag).find('"', 1) - 1);
    EXPECT_NE(Fault(four + ", " + flag).find("the lens model " + name), std::string::npos) << flag;
  }
  EXPECT_NE(Fault(four + R"(, "k5": 0.1)").find("OPENCV with k5 or k6"), std::string::npos);
  // what tells of the world, of masks and of other programs' settings
  EXPECT_EQ(
      Fault(four + R"(, "aabb_scale": 16, "scale": 0.3, "offset": [0, 0, 0], "applied_scale": 2,
      "applied_transform": [[0,1,0,0],[1,0,0,0],[0,0,-1,0]], "ply_file_path": "sparse.ply",
      "orientation_override": "none", "from_na": false, "latlong": false, "rolling_shutter": [0,0,0,0])",
            R"("mask_path": "m.png", "depth_file_path": "d.png", "colmap_im_id": 3, "sharpness": 9,
      "time": 0.5)"),
      "none");
}

TEST_F(Transforms, NamesHaveAsManyFoldersAsTellThemApart) {
  const auto names = [&](const std::vector<std::string>& paths) {
    nlohmann::json root{{"w", 400}, {"h", 300}, {"fl_x", 500}, {"frames", nlohmann::json::array()}};
    for (const std::string& path : paths)
      root["frames"].push_back(
          {{"file_path", path}, {"transform_matrix", {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}}});
    std::vector<std::string> found;
    for (const LensView& view : ReadLensPoses(Put("transforms.json", root.dump())))
      found.push_back(view.name);
    return found;
  };
  EXPECT_EQ(names({"photos\\IMG1.jpg", ".\\photos\\IMG0.jpg"}),
            (std::vector<std::string>{"IMG0.jpg", "IMG1.jpg"}));
  EXPECT_EQ(names({"./left/1.jpg", "./right/1.jpg", "images/2.jpg"}),
            (std::vector<std::string>{"2.jpg", "left/1.jpg", "right/1.jpg"}));
  EXPECT_THROW(names({"a/1.jpg", "./a/1.jpg"}), InputError);
}

TEST_F(Transforms, ReportedFilesAreReadRight) {
  const fs::path folder = DataFolder() / "reports" / "18_transforms_json";
  if (!fs::exists(folder)) GTEST_SKIP() << folder << " is not there";
  const std::vector<View> plain = ReadPoses(folder / "plain.json"),
                          windows = ReadPoses(folder / "backslashes.json");
  ASSERT_EQ(plain.size(), 6u);
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(windows[i].name, plain[i].name);
    EXPECT_EQ(windows[i].Center(), plain[i].Center());
  }
  EXPECT_LT((plain[1].Center() -
             Eigen::Vector3d(2.8190778623577253, 4.882786088096241, 2.0521208599540124))
                .norm(),
            1e-9);
  const Lens fisheye = ReadLensPoses(folder / "is_fisheye.json")[0].lens;
  // theta = 0.6 at 300 pixels a radian, times 1 + 0.12 t^2 - 0.05 t^4 + 0.02 t^6 - 0.003 t^8
  const double t = 0.6, r = 300 * t *
                            (1 + 0.12 * t * t - 0.05 * std::pow(t, 4) + 0.02 * std::pow(t, 6) -
                             0.003 * std::pow(t, 8));
  const Eigen::Vector3d x(std::sin(t), 0, std::cos(t));
  EXPECT_NEAR(fisheye.Project(x)->x(), 200 + r, 1e-9);
  EXPECT_LT(
      (ReadPoses(folder / "is_fisheye.json")[0].camera.Project(x) - *fisheye.Project(x)).norm(),
      kSameLens_px);
}

}  // namespace keypose::transforms_io_test
