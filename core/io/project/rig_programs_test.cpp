#include <gtest/gtest.h>

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>

#include "core/io/project/rig_calibration.h"
#include "core/io/testing/rig_files.h"
#include "core/io/text/files.h"
#include "core/testing/paths.h"
#include "core/values/errors.h"

namespace keypose::rig_programs_test {

/// Four cameras as in RigTest::Ring, as other programs write them.
class RigPrograms : public RigTest {
 protected:
  std::string Fault(const fs::path& path) const {
    try {
      ReadRigCalibration(path);
    } catch (const InputError& error) {
      return error.what();
    }
    return "none";
  }
  /// 16 numbers in rows.
  static std::string Rows(const Rigid3& pose) {
    const Eigen::Matrix3d r = pose.rotation.toRotationMatrix();
    std::string text = "[";
    for (int i = 0; i < 3; ++i)
      text += fmt::format("[{:.17g}, {:.17g}, {:.17g}, {:.17g}], ", r(i, 0), r(i, 1), r(i, 2),
                          pose.translation[i]);
    return text + "[0, 0, 0, 1]]";
  }
  static std::string Numbers(const Eigen::Vector3d& v) {
    return fmt::format("[{:.17g}, {:.17g}, {:.17g}]", v.x(), v.y(), v.z());
  }
  static Eigen::Vector3d RodriguesOf(const View& view) {
    const Eigen::AngleAxisd turn(view.camera_from_world.rotation);
    return turn.angle() * turn.axis();
  }
};

TEST_F(RigPrograms, Kalibr) {
  const auto ring = Ring();
  std::string text;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    text += fmt::format(
        "cam{}:\n  camera_model: pinhole\n  intrinsics: [900, 901, 509.75, 395]\n  "
        "distortion_model: "
        "radtan\n  distortion_coeffs: [0.01, -0.02, 0.001, 0.002]\n  resolution: [1000, 800]\n"
        "  rostopic: /cam{}/image_raw\n",
        i, i);
    if (i > 0)
      text += "  T_cn_cnm1: " +
              Rows(Compose(ring[i].camera_from_world, ring[i - 1].camera_from_world.Inverse())) +
              "\n";
  }
  const RigCalibration rig = ReadRigCalibration(Put("camchain.yaml", text));
  EXPECT_EQ(rig.format, "Kalibr");
  EXPECT_EQ(rig.metres_per_unit, 1);
  ASSERT_EQ(rig.views.size(), 4u);
  const Rigid3 first_from_world = ring[0].camera_from_world;
  for (std::size_t i = 0; i < 4; ++i) {
    const Eigen::Vector3d x(0.3, -0.4, 1.1);
    EXPECT_LT((rig.views[i].Project(first_from_world * x) - ring[i].Project(x)).norm(), 1e-9) << i;
  }
}

TEST_F(RigPrograms, KalibrsOtherLensesAreUsedOrNamed) {
  const auto file = [&](const std::string& model, const std::string& intrinsics,
                        const std::string& distortion, const std::string& coefficients) {
    return Put("camchain.yaml",
               "cam0:\n  camera_model: " + model + "\n  intrinsics: " + intrinsics +
                   "\n  distortion_model: " + distortion +
                   "\n  distortion_coeffs: " + coefficients + "\n  resolution: [400, 300]\n");
  };
  const std::string k = "500, 500, 200, 150]";
  EXPECT_EQ(Fault(file("pinhole", "[" + k, "none", "[]")), "none");
  EXPECT_EQ(Fault(file("pinhole", "[" + k, "equidistant", "[0.05, -0.02, 0.01, 0.002]")), "none");
  EXPECT_EQ(Fault(file("omni", "[0, " + k, "radtan", "[0.01, 0, 0, 0]")), "none");
  EXPECT_EQ(Fault(file("eucm", "[0, 1, " + k, "none", "[]")), "none");
  EXPECT_EQ(Fault(file("ds", "[0, 0, " + k, "none", "[]")), "none");
  for (const auto& [path, name] : std::vector<std::pair<fs::path, std::string>>{
           {file("omni", "[1.5, 300, 300, 200, 150]", "radtan", "[0.01, 0, 0, 0]"), "omni-radtan"}})
    EXPECT_NE(Fault(path).find("cam0: its lens model " + name), std::string::npos) << Fault(path);
  EXPECT_NE(Fault(file("ds", "[-0.2, 0.6, 150, 150, 200, 150]", "none", "[]")).find("ds-none"),
            std::string::npos);
  EXPECT_NE(Fault(file("scaramuzza", "[" + k, "none", "[]")).find("the lens model scaramuzza"),
            std::string::npos);
  EXPECT_NE(Fault(file("pinhole", "[500, 500]", "none", "[]")).find("`intrinsics` of pinhole"),
            std::string::npos);
}

TEST_F(RigPrograms, McCalib) {
  std::string text = "%YAML:1.0\n---\nnb_camera: 4\n";
  const auto ring = Ring();
  const auto matrix = [](const char* name, int rows, int cols, const std::string& data) {
    return fmt::format(
        "   {}: !!opencv-matrix\n      rows: {}\n      cols: {}\n      dt: d\n      data: {}\n",
        name, rows, cols, data);
  };
  for (std::size_t i = 0; i < 4; ++i) {
    std::string pose = Rows(ring[i].camera_from_world.Inverse());
    std::erase_if(pose, [](char c) { return c == '[' || c == ']'; });
    text += fmt::format("camera_{}:\n", i) +
            matrix("camera_matrix", 3, 3, "[900, 0, 509.75, 0, 901, 395, 0, 0, 1]") +
            matrix("distortion_vector", 1, 5, "[0.01, -0.02, 0.001, 0.002, 0]") +
            "   distortion_type: 0\n   camera_group: 0\n   img_width: 1000\n   img_height: 800\n" +
            matrix("camera_pose_matrix", 4, 4, "[" + pose + "]");
  }
  const RigCalibration rig = ReadRigCalibration(Put("calibrated_cameras_data.yml", text));
  EXPECT_EQ(rig.format, "MC-Calib");
  EXPECT_EQ(rig.views[2].camera.width, 1000);
  for (std::size_t i = 0; i < 4; ++i) {
    const Eigen::Vector3d x(0.3, -0.4, 1.1);
    EXPECT_LT((rig.views[i].Project(x) - ring[i].Project(x)).norm(), 1e-9) << i;
  }
  std::string other = text;
  other.replace(other.find("distortion_type: 0"), 18, "distortion_type: 7");
  EXPECT_NE(Fault(Put("rig.yml", other)).find("camera_0: MC-Calib's distortion_type 7"),
            std::string::npos);
  std::string groups = text;
  groups.replace(groups.rfind("camera_group: 0"), 15, "camera_group: 1");
  EXPECT_NE(Fault(Put("rig.yml", groups)).find("2 camera groups"), std::string::npos);
}

TEST_F(RigPrograms, EasyMocapsPair) {
  const auto ring = Ring();
  std::string intri = "%YAML:1.0\r\n---\r\nnames:\r\n", extri;
  for (const View& view : ring) intri += "  - \"" + view.name + "\"\r\n";
  extri = intri;
  const auto matrix = [](const std::string& name, int rows, int cols, const std::string& data) {
    return fmt::format(
        "{}: !!opencv-matrix\r\n  rows: {}\r\n  cols: {}\r\n  dt: d\r\n  data: {}\r\n", name, rows,
        cols, data);
  };
  for (const View& view : ring) {
    intri += matrix("K_" + view.name, 3, 3, "[900, 0, 509.75, 0, 901, 395, 0, 0, 1]") +
             matrix("dist_" + view.name, 1, 5, "[0.01, -0.02, 0.001, 0.002, 0]") +
             fmt::format("H_{0}: 800\r\nW_{0}: 1000\r\n", view.name);
    extri += matrix("R_" + view.name, 3, 1, Numbers(RodriguesOf(view))) +
             matrix("T_" + view.name, 3, 1, Numbers(view.camera_from_world.translation));
  }
  Put("intri.yml", intri);
  Put("extri.yml", extri);
  const RigCalibration rig = ReadRigCalibration(folder_);
  EXPECT_EQ(rig.format, "EasyMocap");
  EXPECT_EQ(rig.views[1].camera.height, 800);
  ExpectSame(rig.views, ring, 1e-9);
  Put("extri.yml", "%YAML:1.0\n---\nnames: [a]\n");
  EXPECT_NE(Fault(folder_).find("camera cam1: extri.yml has no T_cam1"), std::string::npos);
}

TEST_F(RigPrograms, AniposeFreeMoCapAndPose2Sim) {
  const auto ring = Ring();
  const auto table = [&](std::size_t i, const std::string& more) {
    return fmt::format(
        "[cam_{}]\nname = \"{}\"\nsize = [ 1000, 800,]\nmatrix = [ [ 900.0, 0.0, 509.75,], "
        "[ 0.0, 901, 395.0,], [ 0.0, 0.0, 1.0,],]\ndistortions = [ 0.01, -0.02, 0.001, "
        "0.002, 0.0,]\nrotation = {}\ntranslation = {}\n{}\n",
        i, ring[i].name, Numbers(RodriguesOf(ring[i])),
        Numbers(ring[i].camera_from_world.translation), more);
  };
  std::string text;
  for (std::size_t i : {2u, 0u, 3u, 1u})
    text += table(i, "fisheye = false\nworld_position = [ 1.0, 2.0, 3.0,]");
  const RigCalibration rig = ReadRigCalibration(
      Put("calibration.toml", text + "[metadata]\nadjusted = false\nerror = 0.2\n"));
  EXPECT_EQ(rig.format, "anipose");
  EXPECT_EQ(rig.metres_per_unit, 0);
  EXPECT_EQ(rig.views[3].camera.width, 1000);
  ExpectSame(rig.views, ring, 1e-9);
  EXPECT_NE(Fault(Put("calibration.toml", table(0, "fisheye = true")))
                .find("camera cam1: its lens model fisheye"),
            std::string::npos);
  EXPECT_NE(Fault(Put("calibration.toml", "[cam_0]\nmatrix = [[1, 2], [3, 4]]\n"))
                .find("`matrix` must hold 9"),
            std::string::npos);
  EXPECT_NE(Fault(Put("calibration.toml", "[cam_0\n")).find("is not whole TOML"),
            std::string::npos);
  EXPECT_NE(
      Fault(Put("calibration.toml", "# Kamera vor der T\xfcr\na = 1\n")).find("is not UTF-8 text"),
      std::string::npos);
  EXPECT_NE(Fault(Put("calibration.toml", "a = " + std::string(60, '['))).find("nested too deeply"),
            std::string::npos);
}

// A file that OpenCV itself writes, with the words that its programs and ROS use.
TEST_F(RigPrograms, OpenCvsYamlAndJson) {
  for (const char* name : {"rig.yml", "rig.json"}) {
    const std::string file = (folder_ / name).string();
    cv::FileStorage storage(file, cv::FileStorage::WRITE);
    for (const View& view : Ring()) {
      storage << view.name << "{";
      storage << "image_width" << 1000 << "image_height" << 800 << "distortion_model"
              << "plumb_bob";
      storage << "camera_matrix" << (cv::Mat_<double>(3, 3) << 900, 0, 509.75, 0, 901, 395, 0, 0, 1)
              << "distortion_coefficients"
              << (cv::Mat_<double>(1, 5) << 0.01, -0.02, 0.001, 0.002, 0);
      const Eigen::Matrix3d r = view.camera_from_world.rotation.toRotationMatrix();
      const Eigen::Vector3d t = view.camera_from_world.translation;
      storage << "rotation"
              << (cv::Mat_<double>(3, 3) << r(0, 0), r(0, 1), r(0, 2), r(1, 0), r(1, 1), r(1, 2),
                  r(2, 0), r(2, 1), r(2, 2))
              << "translation" << (cv::Mat_<double>(3, 1) << t.x(), t.y(), t.z());
      storage << "}";
    }
    storage.release();
    ExpectSame(ReadRigCalibration(file).views, Ring(), 1e-9);
  }
}

TEST_F(RigPrograms, OpenCvItselfReadsWhatIsWritten) {
  const auto ring = Ring();
  const cv::FileStorage storage(Put("rig.yml", OpenCvYaml(ring)).string(), cv::FileStorage::READ);
  for (const View& view : ring) {
    cv::Mat matrix, translation;
    storage[view.name]["camera_matrix"] >> matrix;
    storage[view.name]["translation"] >> translation;
    ASSERT_EQ(matrix.rows, 3) << view.name;
    EXPECT_EQ(matrix.at<double>(0, 2), 509.75);
    EXPECT_EQ(translation.at<double>(2), view.camera_from_world.translation.z());
  }
}

TEST_F(RigPrograms, NamesThatAreNoPlainWordsReadBack) {
  auto ring = Ring();
  const std::vector<std::string> names{"01", "cam: 1", "left #2", "-3"};
  for (std::size_t i = 0; i < 4; ++i) ring[i].name = names[i];
  ExpectSame(ReadRigCalibration(Put("rig.yml", OpenCvYaml(ring))).views, ring, 1e-9);
}

TEST_F(RigPrograms, LensesThatK1AndK2DoNotHoldAreNamed) {
  const auto file = [&](const std::string& coefficients, const std::string& word) {
    return Put("rig.yml",
               "cam1:\n  image_width: 1280\n  image_height: 720\n  K: [900, 0, 639.5, 0, 900, "
               "359.5, 0, 0, 1]\n  D: " +
                   coefficients + "\n  rvec: [0, 0, 0]\n  tvec: [0, 0, 3]\n" +
                   (word.empty() ? "" : "  " + word + "\n"));
  };
  EXPECT_EQ(Fault(file("[0.1, 0, 0, 0]", "")), "none");
  EXPECT_EQ(Fault(file("[0.1, 0, 0, 0]", "camera_model: D435")), "none");
  EXPECT_NE(Fault(file("[0.1, 0, 0, 0]", "camera_model: omnidirectional"))
                .find("the lens model omnidirectional"),
            std::string::npos);
  EXPECT_EQ(Fault(file("[0.1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]", "")), "none");
  const std::string rational = "[9.4, 21, 0.0006, -0.0004, 1.9, 9.55, 22.1, 3.3]";
  EXPECT_NE(
      Fault(file(rational, "")).find("rig.yml, cam1: its lens model OpenCV's with 8 coefficients"),
      std::string::npos);
  EXPECT_NE(Fault(file(rational, "distortion_model: rational_polynomial"))
                .find("model rational_polynomial"),
            std::string::npos);
  for (const char* word : {"distortion_model: equidistant", "camera_model: fisheye",
                           "fisheye: true", "fisheye_model: 1", "distortion_type: fisheye"})
    EXPECT_NE(Fault(file("[0.03, -0.01, 0.004, -0.0008]", word)).find("cam1: its lens model "),
              std::string::npos)
        << word;
  EXPECT_NE(Fault(file("[1, 2, 3]", "")).find("has 3 coefficients"), std::string::npos);
}

TEST_F(RigPrograms, ReportedFilesAreReadRightOrNamed) {
  const fs::path folder = DataFolder() / "reports" / "20_rig_calibrations";
  if (!fs::exists(folder)) GTEST_SKIP() << folder << " is not there";
  const auto truth = nlohmann::json::parse(ReadFile(folder / "truth.json"));
  for (const char* name : {"brown4.yml", "easymocap"}) {
    const RigCalibration rig = ReadRigCalibration(folder / name);
    ASSERT_EQ(rig.views.size(), 4u);
    int i = 0;
    for (const auto& [camera, place] : truth.items()) {
      const auto& c = place["center"];
      EXPECT_LT((rig.views[i].Center() - Eigen::Vector3d(c[0], c[1], c[2])).norm(), 1e-6)
          << name << i;
      EXPECT_EQ(rig.views[i++].camera.k1, -0.12);
    }
  }
  EXPECT_NE(Fault(folder / "rational8.yml").find("cam0: its lens model OpenCV's with 8"),
            std::string::npos);
  EXPECT_NE(Fault(folder / "fisheye_named.yml").find("cam0: its lens model equidistant"),
            std::string::npos);
}

}  // namespace keypose::rig_programs_test
