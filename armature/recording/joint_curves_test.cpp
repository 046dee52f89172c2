#include "armature/recording/joint_curves.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "armature/recording/testing/walk.h"
#include "armature/testing/theropods.h"
#include "core/io/meshes/bvh_io.h"
#include "core/values/errors.h"

namespace keypose::armature::joint_curves_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(Curves, AreReadAgainToTheBit) {
  const Armature theropod = MakeTheropod();
  const JointCurves made = Walk(theropod, 7, 2);
  const JointCurves read = ParseCurvesJson(CurvesJson(theropod, made), "c.json", theropod);
  EXPECT_EQ(read.values, made.values);
  EXPECT_EQ(read.step, 2);
  EXPECT_EQ(read.fps, 24);
}

TEST(Curves, BvhStandsWhereTheArmatureStands) {
  const Armature theropod = MakeTheropod();
  const JointCurves curves = Walk(theropod, 5, 2);
  const MotionClip clip = ParseBvh(BvhText(CurvesClip(theropod, curves)), "c.bvh");
  ASSERT_EQ(clip.frame_count(), 10);
  for (int f = 0; f < clip.frame_count(); ++f) {
    const Eigen::RowVectorXd row = curves.values.row(f / 2);
    const auto wanted = ForwardKinematics(theropod, {row.data(), row.data() + row.size()});
    const auto frames = JointFrames(clip, f);
    for (std::size_t n = 0; n < wanted.size(); ++n) {
      const auto& frame = frames[static_cast<std::size_t>(clip.Find(theropod.nodes[n].name))];
      // Six decimals of degrees and of metres in the file, along a chain of fifty nodes.
      EXPECT_LT((frame.translation - wanted[n].translation).norm(), 2e-5);
      EXPECT_LT(frame.rotation.angularDistance(wanted[n].rotation), 1e-6);
    }
  }
}

/// How often a word stands in a text.
std::size_t CountOf(const std::string& text, const std::string& word) {
  std::size_t count = 0;
  for (auto at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) ++count;
  return count;
}

TEST(Curves, BvhIsOneThatOtherProgramsRead) {
  Armature theropod = MakeTheropod();
  theropod.nodes[0].name = "armature";
  const std::string text = BvhText(CurvesClip(theropod, Walk(theropod, 1, 1)));
  // Blender and three.js expect channels of each joint; names are their own.
  EXPECT_EQ(CountOf(text, "CHANNELS"), theropod.nodes.size() + 1);
  EXPECT_EQ(CountOf(text, "CHANNELS 0"), 0u);
  EXPECT_EQ(CountOf(text, "JOINT armature\n") + CountOf(text, "ROOT armature\n"), 1u);
}

TEST(Curves, OfAnotherArmatureOrDamagedAreAFault) {
  const Armature theropod = MakeTheropod();
  Armature other = theropod;
  other.nodes[static_cast<std::size_t>(other.joints[5])].name = "else";
  const std::string text = CurvesJson(theropod, Walk(theropod, 2, 1));
  const auto fault = [&](const std::string& damaged) -> std::string {
    try {
      ParseCurvesJson(damaged, "c.json", other);
    } catch (const InputError& error) {
      return error.what();
    }
    return "no fault";
  };
  const std::string old = theropod.nodes[static_cast<std::size_t>(theropod.joints[5])].name;
  EXPECT_THAT(fault(text), HasSubstr("c.json: it has no joint 'else', but '" + old + "', which"));
  EXPECT_THAT(fault(text.substr(0, 100)), HasSubstr("c.json: these are no curves"));
  EXPECT_THAT(fault("[]"), HasSubstr("c.json: these are no curves"));
  EXPECT_THAT(fault(R"({"fps":0,"step":1})"), HasSubstr("must be positive"));
}

TEST(Curves, AJointThatTheDescriptionLostIsNamedAndTheOthersStay) {
  const Armature theropod = MakeTheropod();
  const JointCurves made = Walk(theropod, 3, 1);
  Armature fewer = theropod;
  const std::string gone = fewer.nodes[static_cast<std::size_t>(fewer.joints.back())].name;
  fewer.joints.pop_back();
  const JointCurves read = ParseCurvesJson(CurvesJson(theropod, made), "c.json", fewer);
  EXPECT_THAT(read.left_out, ElementsAre(gone));
  EXPECT_EQ(read.values, made.values.leftCols(made.values.cols() - 1));
  EXPECT_THAT(LeftOutWords(read),
              HasSubstr("a joint '" + gone + "', which the description has not"));
  EXPECT_EQ(LeftOutWords(made), "");
  fewer.joints.resize(2);
  EXPECT_THAT(LeftOutWords(ParseCurvesJson(CurvesJson(theropod, made), "c.json", fewer)),
              HasSubstr(" and 67 more"));
}

TEST(Curves, CsvHasALineAFrame) {
  const Armature theropod = MakeTheropod();
  const std::string csv = CurvesCsv(theropod, Walk(theropod, 3, 2));
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 4);
  EXPECT_THAT(csv, HasSubstr("frame,time_s,rigAcross_m,"));
  EXPECT_THAT(csv, HasSubstr(",leftKneeBend_deg,"));
}

}  // namespace keypose::armature::joint_curves_test
