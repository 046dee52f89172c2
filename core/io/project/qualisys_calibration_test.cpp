#include "core/io/project/qualisys_calibration.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <filesystem>

#include "core/io/project/rig_calibration.h"
#include "core/io/testing/rig_files.h"
#include "core/testing/paths.h"
#include "core/values/errors.h"

namespace keypose::qualisys_calibration_test {

namespace fs = std::filesystem;

std::string Qualisys(const std::vector<View>& views, bool transposed, bool backwards) {
  std::string text = "<?xml version=\"1.0\"?>\n<calibration><cameras>\n";
  for (const View& view : views) {
    const auto number = [](double x) { return "\"" + std::to_string(x) + "\""; };
    Eigen::Matrix3d m = view.camera_from_world.rotation.toRotationMatrix();
    if (backwards) m.row(1) *= -1, m.row(2) *= -1;
    if (transposed) m.transposeInPlace();
    const Eigen::Vector3d c = 1000 * view.Center();
    text += "<camera active=\"1\" serial=\"" + view.name + "\">\n<transform x=" + number(c.x()) +
            " y=" + number(c.y()) + " z=" + number(c.z());
    for (int i = 0; i < 9; ++i)
      text += " r" + std::to_string(i / 3 + 1) + std::to_string(i % 3 + 1) + "=" +
              number(m(i / 3, i % 3));
    const Camera& k = view.camera;
    text += "/>\n<intrinsic sensorMinU=\"0\" sensorMaxU=" + number(64 * k.width - 1) +
            " sensorMinV=\"0\" sensorMaxV=" + number(64 * k.height - 1) +
            " focalLengthU=" + number(64 * k.fx) + " focalLengthV=" + number(64 * k.fy) +
            " centerPointU=" + number(64 * (k.cx - 0.5)) +
            " centerPointV=" + number(64 * (k.cy - 0.5)) + " radialDistortion1=" + number(k.k1) +
            " radialDistortion2=" + number(k.k2) + " tangentalDistortion1=" + number(k.p1) +
            " tangentalDistortion2=" + number(k.p2) + "/>\n</camera>\n";
  }
  return text + "</cameras></calibration>\n";
}

TEST_F(RigTest, QualisysIsReadWhicheverWayItsMatrixTurns) {
  for (const bool transposed : {false, true})
    for (const bool backwards : {false, true}) {
      const RigCalibration rig =
          ReadRigCalibration(Put("rig.qca.txt", Qualisys(Ring(), transposed, backwards)));
      EXPECT_EQ(rig.format, "Qualisys");
      EXPECT_EQ(rig.metres_per_unit, 1);
      // six decimals of the text
      ExpectSame(rig.views, Ring(), 0.01);
    }
}

TEST_F(RigTest, QualisysNamesTheLastPixelOrItsLastPart) {
  std::string text = Qualisys(Ring(), false, false);
  const auto put = [&text](const std::string& old, const std::string& other) {
    for (std::size_t at = 0; (at = text.find(old, at)) != std::string::npos; at += other.size())
      text.replace(at, old.size(), other);
  };
  put("sensorMaxU=\"63999.000000\"", "sensorMaxU=\"63936.000000\"");  // 64 * 999
  put("sensorMaxV=\"51199.000000\"", "sensorMaxV=\"51136.000000\"");  // 64 * 799
  const RigCalibration rig = ReadRigCalibration(Put("rig.qca.txt", text));
  EXPECT_EQ(rig.views[0].camera.width, 1000);
  EXPECT_EQ(rig.views[0].camera.height, 800);
  EXPECT_EQ(rig.up, Eigen::Vector3d(0, 0, 1));
  ExpectSame(rig.views, Ring(), 0.01);
}

TEST_F(RigTest, QualisysFilmOfAWindowOfTheSensorIsItsWindow) {
  std::string text = Qualisys(Ring(), false, false);
  text.replace(text.find("<transform"), 0,
               "<fov_video left=\"100\" top=\"60\" right=\"899\" bottom=\"659\"/>\n");
  const RigCalibration rig = ReadRigCalibration(Put("rig.qca.txt", text));
  EXPECT_EQ(rig.views[0].camera.width, 800);
  EXPECT_EQ(rig.views[0].camera.height, 600);
  EXPECT_NEAR(rig.views[0].camera.cx, Ring()[0].camera.cx - 100, 1e-4);
  EXPECT_NEAR(rig.views[0].camera.cy, Ring()[0].camera.cy - 60, 1e-4);
  EXPECT_EQ(rig.views[1].camera.width, 1000) << "it has no window";
}

TEST_F(RigTest, QualisysCameraWithoutALensIsLeftOutAndNamed) {
  std::string text = Qualisys(Ring(), false, false);
  text.replace(text.find("</cameras>"), 0, "<camera serial=\"marker9\"></camera>\n");
  const RigCalibration rig = ReadRigCalibration(Put("rig.qca.txt", text));
  EXPECT_EQ(rig.views.size(), 4u);
  ASSERT_EQ(rig.notes.size(), 1u);
  EXPECT_NE(rig.notes[0].find("camera marker9 has no lens"), std::string::npos);
}

TEST_F(RigTest, QualisysThatEndsInTheMiddleIsAnError) {
  const std::string text = Qualisys(Ring(), false, false);
  for (const double share : {0.3, 0.7, 0.98})
    EXPECT_THROW(ReadRigCalibration(Put(
                     "rig.qca.txt", text.substr(0, static_cast<std::size_t>(share * text.size())))),
                 InputError);
}

TEST_F(RigTest, QualisysOfARealRoomHasThePicturesSize) {
  const fs::path file = DataFolder() / "motion/gym/Calib.qca.txt";
  if (!fs::exists(file)) GTEST_SKIP() << file << " is not here; set KEYPOSE_DATA";
  const RigCalibration rig = ReadRigCalibration(file);
  ASSERT_EQ(rig.views.size(), 4u);
  for (const View& view : rig.views) {
    EXPECT_EQ(view.camera.width, 1088) << view.name;
    EXPECT_EQ(view.camera.height, 1920) << view.name;
  }
}

}  // namespace keypose::qualisys_calibration_test
