#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <filesystem>
#include <fstream>

#include "core/io/meshes/bvh_io.h"
#include "core/io/project/rig_calibration.h"
#include "core/pictures/render.h"
#include "core/testing/folder.h"
#include "core/testing/paths.h"
#include "core/values/angles.h"
#include "core/values/errors.h"

namespace keypose::motion_io_test {
namespace fs = std::filesystem;

const char* const kClip =
    "HIERARCHY\nROOT Hips\n{\n\tOFFSET 0 0 0\n"
    "\tCHANNELS 6 Xposition Yposition Zposition Zrotation Yrotation Xrotation\n"
    "\tJOINT Knee\n\t{\n\t\tOFFSET 0 -2 0\n\t\tCHANNELS 3 Zrotation Xrotation Yrotation\n"
    "\t\tEnd Site\n\t\t{\n\t\t\tOFFSET 0 -1 0\n\t\t}\n\t}\n}\n"
    "MOTION\nFrames: 2\nFrame Time: 0.04\n"
    "1 2 3 90 0 0 0 0 0\n0 0 0 0 0 0 0 90 0\n";

TEST(Bvh, ChannelsTurnInTheirOrder) {
  const MotionClip clip = ParseBvh(kClip, "clip.bvh");
  ASSERT_EQ(clip.joints.size(), 3u);
  EXPECT_EQ(clip.frame_count(), 2);
  EXPECT_DOUBLE_EQ(clip.frame_time_s, 0.04);
  // Turned by 90 degrees about z, the leg that hangs along -y points along +x.
  const std::vector<Rigid3> first = JointFrames(clip, 0);
  EXPECT_LT((first[1].translation - Eigen::Vector3d(3, 2, 3)).norm(), 1e-12);
  EXPECT_LT((first[2].translation - Eigen::Vector3d(4, 2, 3)).norm(), 1e-12);
  // The knee turns about x: the end, along -y, goes to -z.
  const std::vector<Rigid3> second = JointFrames(clip, 1);
  EXPECT_LT((second[2].translation - Eigen::Vector3d(0, -2, -1)).norm(), 1e-12);
}

TEST(Bvh, WrittenClipReadsTheSame) {
  const MotionClip clip = ParseBvh(kClip, "clip.bvh");
  const MotionClip again = ParseBvh(BvhText(clip), "again");
  ASSERT_EQ(again.joints.size(), clip.joints.size());
  for (std::size_t j = 0; j < clip.joints.size(); ++j) {
    EXPECT_EQ(again.joints[j].name, clip.joints[j].name);
    EXPECT_EQ(again.joints[j].parent, clip.joints[j].parent);
    EXPECT_EQ(again.joints[j].channels, clip.joints[j].channels);
  }
  EXPECT_EQ(again.values, clip.values);
}

TEST(Bvh, FilesOfOtherProgramsReadTheSame) {
  std::string text = "# exported\n" + std::string(kClip);
  text.insert(text.find("MOTION"), "// the numbers\n");
  text.replace(text.find("Xposition"), 9, "XPosition");
  for (std::size_t at = 0; (at = text.find('\n', at)) != std::string::npos; at += 2)
    text.replace(at, 1, "\r\n");
  const MotionClip plain = ParseBvh(kClip, "clip.bvh"),
                   other = ParseBvh("\xEF\xBB\xBF" + text, "other.bvh");
  EXPECT_EQ(other.values, plain.values);
  ASSERT_EQ(other.joints.size(), plain.joints.size());
  for (std::size_t j = 0; j < plain.joints.size(); ++j) {
    EXPECT_EQ(other.joints[j].name, plain.joints[j].name);
    EXPECT_EQ(other.joints[j].channels, plain.joints[j].channels);
  }
}

TEST(Bvh, DamagedFilesNameTheLine) {
  const std::string text = kClip;
  const auto fault = [](const std::string& damaged) {
    try {
      ParseBvh(damaged, "clip.bvh");
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("none");
  };
  EXPECT_NE(fault(text.substr(0, text.size() - 20)).find("line 1"), std::string::npos);
  EXPECT_NE(fault("hello").find("HIERARCHY"), std::string::npos);
  std::string odd = text;
  odd.replace(odd.find("Xposition"), 9, "Xposltion");
  EXPECT_NE(fault(odd).find("line 5: 'Xposltion' is not a channel"), std::string::npos);
  std::string huge = text;
  huge.replace(huge.find("Frames: 2"), 9, "Frames: 9000000");
  EXPECT_NE(fault(huge).find("9000000"), std::string::npos);
}

TEST(EulerZyx, RotatesBack) {
  for (const double y : {-90.0, -40.0, 0.0, 75.0, 90.0}) {
    const Eigen::Matrix3d r = (Eigen::AngleAxisd(130 * kDegree, Eigen::Vector3d::UnitZ()) *
                               Eigen::AngleAxisd(y * kDegree, Eigen::Vector3d::UnitY()) *
                               Eigen::AngleAxisd(-70 * kDegree, Eigen::Vector3d::UnitX()))
                                  .toRotationMatrix();
    const Eigen::Vector3d a = EulerZyx(r);
    const Eigen::Matrix3d back = (Eigen::AngleAxisd(a[0], Eigen::Vector3d::UnitZ()) *
                                  Eigen::AngleAxisd(a[1], Eigen::Vector3d::UnitY()) *
                                  Eigen::AngleAxisd(a[2], Eigen::Vector3d::UnitX()))
                                     .toRotationMatrix();
    EXPECT_LT((back - r).norm(), 1e-7) << y;
  }
}

class RigTest : public ::testing::Test, public TestingFolder {
 protected:
  static std::vector<View> Ring() {
    std::vector<View> views;
    for (int i = 0; i < 4; ++i) {
      View view;
      view.name = "cam" + std::to_string(i + 1);
      view.camera = {1000, 800, 900, 901, 510.25, 395.5, 0.01, -0.02, 0.001, 0.002};
      const double a = 1.5 * i;
      view.camera_from_world = LookAt({4 * std::cos(a), 4 * std::sin(a), 1.5}, {0, 0, 0.9});
      views.push_back(view);
    }
    return views;
  }
  static void ExpectSame(const std::vector<View>& a, const std::vector<View>& b, double lens_px) {
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
      EXPECT_EQ(a[i].name, b[i].name);
      const Eigen::Vector3d x(0.3, -0.4, 1.1);
      EXPECT_LT((a[i].Project(x) - b[i].Project(x)).norm(), lens_px) << i;
      EXPECT_LT((a[i].Center() - b[i].Center()).norm(), 1e-6) << i;
    }
  }
};

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

TEST_F(RigTest, MatricesAreRead) {
  const RigCalibration rig = ReadRigCalibration(Put(
      "calib.txt", "0\n900 -1.5 500\n0 890 400\n0 0 1\n-0.04 0.06\n1 0 0 0.5\n0 1 0 0\n0 0 1 7\n"));
  ASSERT_EQ(rig.views.size(), 1u);
  EXPECT_EQ(rig.metres_per_unit, 0);
  EXPECT_EQ(rig.views[0].camera.cx, 500.5);
  EXPECT_EQ(rig.views[0].camera.k1, -0.04);
  EXPECT_EQ(rig.views[0].camera_from_world.translation, Eigen::Vector3d(0.5, 0, 7));
  EXPECT_EQ(rig.notes.size(), 1u) << "the skew is not used, and that is said";
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

TEST_F(RigTest, AliasesThatGrowOrContainThemselvesAreRefused) {
  const std::string self = "cam1:\n  K: &k [1, *k]\n";
  std::string growing = "a0: &a0 [1, 2, 3, 4, 5, 6, 7, 8, 9]\n";
  for (int i = 1; i < 8; ++i) {
    const std::string before = "*a" + std::to_string(i - 1), name = "a" + std::to_string(i);
    growing += name + ": &" + name + " [";
    for (int k = 0; k < 9; ++k) growing += (k ? ", " : "") + before;
    growing += "]\n";
  }
  growing += "cam1: {K: *a7}\n";
  for (const std::string& text : {self, growing}) {
    try {
      ReadRigCalibration(Put("rig.yml", text));
      ADD_FAILURE() << text;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find("rig.yml is not YAML"), std::string::npos);
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

}  // namespace keypose::motion_io_test
