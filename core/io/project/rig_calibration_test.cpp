#include "core/io/project/rig_calibration.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <filesystem>

#include "core/io/testing/rig_files.h"
#include "core/values/errors.h"

namespace keypose::rig_calibration_test {

namespace fs = std::filesystem;

TEST_F(RigTest, OpenCvYamlReadsBack) {
  const RigCalibration rig = ReadRigCalibration(Put("rig.yml", OpenCvYaml(Ring())));
  EXPECT_EQ(rig.format, "OpenCV YAML");
  EXPECT_EQ(rig.metres_per_unit, 1);
  ExpectSame(rig.views, Ring(), 1e-9);
}

TEST_F(RigTest, LensesWithoutPlacesAreReadAsLensesOnly) {
  const fs::path file = Put("lenses.yml", OpenCvLensYaml(Ring()));
  const RigCalibration lenses = ReadLensCalibration(file);
  ASSERT_EQ(lenses.views.size(), 4u);
  EXPECT_EQ(lenses.views[2].camera.fx, Ring()[2].camera.fx);
  EXPECT_EQ(lenses.views[2].camera.k2, Ring()[2].camera.k2);
  try {
    ReadRigCalibration(file);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("cam1 has a lens but no place"), std::string::npos);
  }
  EXPECT_EQ(ReadLensCalibration(Put("rig.yml", OpenCvYaml(Ring()))).views.size(), 4u);
}

TEST_F(RigTest, MatricesAreRead) {
  const RigCalibration rig = ReadRigCalibration(Put(
      "calib.txt", "0\n900 -1.5 500\n0 890 400\n0 0 1\n-0.04 0.06\n1 0 0 0.5\n0 1 0 0\n0 0 1 7\n"));
  ASSERT_EQ(rig.views.size(), 1u);
  EXPECT_EQ(rig.metres_per_unit, 0);
  EXPECT_EQ(rig.views[0].camera.cx, 500.5);
  EXPECT_EQ(rig.views[0].camera.k1, -0.04);
  EXPECT_EQ(rig.views[0].camera_from_world.translation, Eigen::Vector3d(0.5, 0, 7));
  EXPECT_EQ(rig.notes.size(), 1u) << "the skew of 0.67 px is not used, and that is said";
}

TEST_F(RigTest, MatricesWithMuchSkewAreRefusedByCamera) {
  const auto file = [&](const std::string& skew) {
    return Put("calib.txt",
               "7\n900 " + skew + " 500\n0 890 400\n0 0 1\n0 0\n1 0 0 0.5\n0 1 0 0\n0 0 1 7\n");
  };
  EXPECT_TRUE(ReadRigCalibration(file("0.2")).notes.empty()) << "0.09 px";
  try {
    ReadRigCalibration(file("-45"));
    ADD_FAILURE();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what())
                  .find("camera 7: its K has skewed pixels, which move by up "
                        "to 20.2 px"),
              std::string::npos)
        << error.what();
  }
  EXPECT_THROW(ReadRigCalibration(file("inf")), InputError);
}

TEST_F(RigTest, MatricesOfAnotherOrderAreRefused) {
  const std::string rest = "\n0 0\n1 0 0 0.5\n0 1 0 0\n0 0 1 7\n";
  for (const char* k : {"900 0 0 0 890 0 500 400 1", "1800 0 1000 0 1780 800 0 0 2"})
    EXPECT_THROW(ReadRigCalibration(Put("calib.txt", "7\n" + std::string(k) + rest)), InputError);
}

TEST_F(RigTest, BadCalibrationsSayWhatIsWrong) {
  EXPECT_THROW(ReadRigCalibration(Put("a.txt", "0\n900 0 500\n0 890")), InputError);
  EXPECT_THROW(ReadRigCalibration(Put("a.yml", "%YAML:1.0\n---\nfoo: 3\n")), InputError);
  EXPECT_THROW(ReadRigCalibration(Put("b.yml", "a: [1, 2")), InputError);
  std::string no_rotation = OpenCvYaml(Ring());
  no_rotation.replace(no_rotation.find("rotation: !!opencv-matrix"), 8, "rotatoin");
  EXPECT_THROW(ReadRigCalibration(Put("c.yml", no_rotation)), InputError);
  EXPECT_THROW(ReadRigCalibration(Put("d.txt", "<calibration></calibration>")), InputError);
}

TEST_F(RigTest, MoreListsOrNumbersThanAMatrixHasAreRefused) {
  const std::string deep =
      "cam1:\n  K: " + std::string(12, '[') + "1" + std::string(12, ']') + "\n";
  std::string many = "a: &a [1";  // 100 numbers, and eleven times the same
  for (int i = 1; i < 100; ++i) many += ", 1";
  many += "]\ncam1: {K: [*a";
  for (int i = 1; i < 11; ++i) many += ", *a";
  many += "]}\n";
  for (const std::string& text : {deep, many}) {
    try {
      ReadRigCalibration(Put("rig.yml", text));
      ADD_FAILURE() << text;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find("rig.yml is not YAML"), std::string::npos);
      EXPECT_NE(std::string(error.what()).find("than any matrix has"), std::string::npos);
    }
  }
}

TEST(MatchCameraNames, ByNameThenNumberThenOrder) {
  std::vector<View> views(3);
  views[0].name = "cam1.jpg", views[1].name = "cam2.jpg", views[2].name = "cam10.jpg";
  EXPECT_EQ(MatchCameraNames({"cam10", "cam2"}, views), (std::vector<int>{2, 1}));
  EXPECT_EQ(MatchCameraNames({"view_02", "view_10"}, views), (std::vector<int>{1, 2}));
  EXPECT_EQ(MatchCameraNames({"left", "middle", "right"}, views), (std::vector<int>{0, 1, 2}));
  EXPECT_EQ(MatchCameraNames({"left", "cam2"}, views), (std::vector<int>{-1, 1}));
}

TEST(NumberedBefore, ComparesNumbers) {
  EXPECT_TRUE(NumberedBefore("cam2", "cam10"));
  EXPECT_FALSE(NumberedBefore("cam10", "cam2"));
  EXPECT_TRUE(NumberedBefore("WD2_9_00020", "WD2_10_00020"));
  EXPECT_TRUE(NumberedBefore("a", "b"));
  EXPECT_FALSE(NumberedBefore("a1", "a1"));
}

}  // namespace keypose::rig_calibration_test
