// Changes of a recorded take.
#include "armature/recording/curve_edits.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "armature/testing/theropods.h"
#include "core/values/angles.h"
#include "core/values/errors.h"

namespace keypose::armature::curve_edits_test {

using ::testing::HasSubstr;

const Armature& TakenTheropod() {
  static const Armature theropod = MakeTheropod();
  return theropod;
}

constexpr int kTurning = 10;  // the first joints slide

/// Frame f has f in its joint 0, and 100 + f in its joint 1.
JointCurves Counted(int frames, int step = 1) {
  JointCurves curves;
  curves.step = step;
  curves.values = Eigen::MatrixXd::Zero(frames, 74);
  for (int f = 0; f < frames; ++f) curves.values(f, 0) = f, curves.values(f, 1) = 100 + f;
  return curves;
}

JointCurves After(const std::string& edits, JointCurves curves = Counted(6)) {
  return EditedCurves(TakenTheropod(), std::move(curves),
                      ParseCurveEdits(edits, "edits.txt", TakenTheropod()));
}

std::vector<double> Joint(const JointCurves& curves, int joint) {
  const Eigen::VectorXd values = curves.values.col(joint);
  return {values.begin(), values.end()};
}

std::string NameOf(int joint) { return TakenTheropod().nodes[TakenTheropod().joints[joint]].name; }

using Values = std::vector<double>;

TEST(CurveEdits, ChangeWhatTheyNameAndNothingElse) {
  const std::string first = NameOf(0);
  EXPECT_EQ(Joint(After("hold " + first + " 1-3"), 0), (Values{0, 1, 1, 1, 4, 5}));
  EXPECT_EQ(Joint(After("hold " + first + " 1-3"), 1), Joint(Counted(6), 1));
  EXPECT_EQ(Joint(After("hold all 1-3"), 1), (Values{100, 101, 101, 101, 104, 105}));
  EXPECT_EQ(Joint(After("set " + first + " 2 180"), 0), (Values{0, 1, 0.18, 3, 4, 5}))
      << "a slide, in millimetres";
  const std::string turning = NameOf(kTurning);
  EXPECT_EQ(Joint(After("set " + turning + " 2 180"), kTurning), (Values{0, 0, kPi, 0, 0, 0}));
  EXPECT_EQ(Joint(After("add " + turning + " 4-5 -90"), kTurning),
            (Values{0, 0, 0, 0, -kPi / 2, -kPi / 2}));
  EXPECT_EQ(Joint(After("move " + first + " 1-2 by 2"), 0), (Values{0, 0, 0, 1, 2, 5}));
  EXPECT_EQ(Joint(After("move " + first + " 3-4 by -2"), 0), (Values{0, 3, 4, 2, 2, 5}));
  EXPECT_EQ(Joint(After("move " + first + " 0 by 1"), 0), (Values{0, 0, 2, 3, 4, 5}));
  EXPECT_EQ(Joint(After("delete 1-3"), 1), (Values{100, 104, 105}));
  EXPECT_EQ(Joint(After("delete 4-5"), 0), (Values{0, 1, 2, 3}));
  EXPECT_EQ(Joint(After("repeat 4 by 2"), 0), (Values{0, 1, 2, 3, 4, 4, 4, 5}));
  EXPECT_EQ(Joint(After("repeat 5 by 1"), 0), (Values{0, 1, 2, 3, 4, 5, 5}));
}

TEST(CurveEdits, OnTwosAndBackKeepsTheLengthAndHardStops) {
  const JointCurves twos = After("step 2");
  EXPECT_EQ(twos.step, 2);
  EXPECT_EQ(Joint(twos, 0), (Values{0, 2, 4}));
  const JointCurves ones = After("step 1", twos);
  EXPECT_EQ(ones.step, 1);
  EXPECT_EQ(Joint(ones, 0), (Values{0, 0, 2, 2, 4, 4}));
  EXPECT_EQ(Joint(After("step 2", Counted(5)), 0), (Values{0, 2, 4})) << "the last one stands";
  EXPECT_EQ(Joint(After("step 3", Counted(4, 2)), 0), (Values{0, 1, 3}));
}

TEST(CurveEdits, AreDoneInTheirOrder) {
  EXPECT_EQ(Joint(After("# blocking\n\ndelete 0\nrepeat 0 by 1  # longer\nhold all 2-4\n"), 0),
            (Values{1, 1, 2, 2, 2, 5}));
}

TEST(CurveEdits, BeyondAJointsLimitsIsRefusedInItsUnits) {
  Armature limited = MakeTheropod();
  const auto node = [&](int joint) -> ArmatureNode& {
    return limited.nodes[limited.joints[joint]];
  };
  node(0).low = -0.05, node(0).high = 0.05;
  node(kTurning).low = -30 * kDegree, node(kTurning).high = 120 * kDegree;
  const auto after = [&](const std::string& text) -> std::string {
    JointCurves still = Counted(6);
    still.values.setZero();
    try {
      const JointCurves made = EditedCurves(limited, still, ParseCurveEdits(text, "e", limited));
      return std::to_string(made.values(2, kTurning) / kDegree);
    } catch (const InputError& error) {
      return error.what();
    }
  };
  const std::string slide = NameOf(0), turning = NameOf(kTurning);
  EXPECT_EQ(after("set " + turning + " 2 120"), "120.000000") << "a limit itself can be had";
  EXPECT_EQ(after("set " + turning + " 2 -30"), "-30.000000");
  EXPECT_EQ(after("set " + turning + " 2 120.5"),
            "line 1 of the edits: joint '" + turning +
                "' would be at 120.5 degrees in frame 2, and its limits are -30 to 120");
  EXPECT_THAT(after("add " + turning + " 0-3 -20\nadd " + turning + " 2 -20"),
              HasSubstr("line 2 of the edits: joint '" + turning + "' would be at -40 degrees"));
  EXPECT_THAT(after("set " + slide + " 1-2 51"), HasSubstr("at 51 mm in frame 1"));
  EXPECT_EQ(after("set " + slide + " 1-2 50"), "0.000000");
}

TEST(CurveEdits, FaultsAreNamedWithTheirLine) {
  const auto fault = [](const std::string& text) -> std::string {
    try {
      After(text);
    } catch (const InputError& error) {
      return error.what();
    }
    return "none";
  };
  EXPECT_THAT(fault("hold all 1-2\nhodl all 3"), HasSubstr("edits.txt, line 2: 'hodl' is no edit"));
  EXPECT_THAT(fault("hodl all 3"), HasSubstr("'hold'"));
  EXPECT_THAT(fault("hold nobody 3"), HasSubstr("no joint is called 'nobody'"));
  EXPECT_THAT(fault("hold all 5-3"), HasSubstr("'5-3' is no frame"));
  EXPECT_THAT(fault("hold all"), HasSubstr("is missing"));
  EXPECT_THAT(fault("set all 2 nan"), HasSubstr("'nan' is no number"));
  EXPECT_THAT(fault("set all 2 3"), HasSubstr("some joints turn and some slide"));
  EXPECT_THAT(fault("set " + NameOf(0) + " 2 1e300"), HasSubstr("'1e300' is beyond 1000000"));
  EXPECT_THAT(fault("set " + NameOf(0) + " 2 4 5"), HasSubstr("'5' is too much"));
  EXPECT_THAT(fault("move all 2 2"), HasSubstr("'by' is wanted"));
  EXPECT_THAT(fault("step 0"), HasSubstr("'0' is no number of frames from 1"));
  EXPECT_THAT(fault("delete 2\nhold all 5"),
              HasSubstr("line 2 of the edits: frame 5 is not there"));
  EXPECT_THAT(fault("delete 0-5"), HasSubstr("no frame would be left"));
  EXPECT_THAT(fault("move all 4-5 by 1"), HasSubstr("would go to 5 to 6"));
  EXPECT_THAT(fault("repeat 2-3 by 1"), HasSubstr("one frame is repeated"));
  EXPECT_THAT(fault("# nothing\n"), HasSubstr("has no edit"));
}

}  // namespace keypose::armature::curve_edits_test
