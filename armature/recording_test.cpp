#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "armature/example/theropod.h"
#include "armature/recording/curves.h"
#include "armature/recording/flipbook.h"
#include "armature/recording/recording_session.h"
#include "armature/recording/still_joints.h"
#include "core/io/meshes/bvh_io.h"
#include "core/io/text/files.h"
#include "core/testing/folder.h"
#include "core/values/errors.h"

namespace keypose::armature::recording_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

JointCurves Walk(const Armature& theropod, int frames, int step) {
  JointCurves curves;
  curves.step = step;
  curves.values.resize(frames, static_cast<Eigen::Index>(theropod.joints.size()));
  for (int f = 0; f < frames; ++f) {
    const std::vector<double> values = TheropodWalk(theropod, f / 12.0);
    curves.values.row(f) = Eigen::Map<const Eigen::RowVectorXd>(
        values.data(), static_cast<Eigen::Index>(values.size()));
  }
  return curves;
}

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

TEST(Flipbook, ShowsEachFrameInItsTime) {
  const Armature theropod = MakeTheropod();
  const std::string svg = FlipbookSvg(theropod, Walk(theropod, 4, 2));
  EXPECT_THAT(svg, HasSubstr("keyTimes=\"0;0.250000;0.500000\" dur=\"0.333333s\""));
  EXPECT_THAT(FlipbookSvg(theropod, Walk(theropod, 0, 1)), HasSubstr("</svg>"));
  EXPECT_THAT(FlipbookJson(theropod, Walk(theropod, 1, 1)), HasSubstr("\"sticks\":[["));
}

std::vector<std::vector<double>> Frames(const Armature& theropod, int count) {
  std::vector<std::vector<double>> frames;
  for (int f = 0; f < count; ++f) frames.push_back(TheropodWalk(theropod, f / 12.0));
  return frames;
}

TEST(StillJoints, NamesTheOneThatStoppedAndNoOther) {
  const Armature theropod = MakeTheropod();
  const int knee = theropod.JointOf(theropod.Find("leftKneeBend"));
  auto frames = Frames(theropod, 9);
  for (int f = 6; f < 9; ++f) frames[f][knee] = frames[5][knee];
  EXPECT_THAT(StillJoints(theropod, frames), ElementsAre(knee));
  frames[7][knee] += 1e-9;
  EXPECT_THAT(StillJoints(theropod, frames), IsEmpty());
}

TEST(StillJoints, IsSilentWhenNothingMovesOrAllDoes) {
  const Armature theropod = MakeTheropod();
  for (int count = 0; count < 60; ++count)
    EXPECT_THAT(StillJoints(theropod, Frames(theropod, count)), IsEmpty());
  auto frames = Frames(theropod, 6);
  for (int f = 0; f < 4; ++f) frames.push_back(frames[5]);  // the puppet holds still
  EXPECT_THAT(StillJoints(theropod, frames), IsEmpty());
}

class Session : public ::testing::Test, public TestingFolder {
 protected:
  std::string Journal() const { return ReadFile(folder_ / "journal.jsonl"); }

  const Armature theropod_ = MakeTheropod();
};

TEST_F(Session, GoesOnWhereItWas) {
  const auto frames = Frames(theropod_, 4);
  {
    RecordingSession session(theropod_, folder_, {});
    for (const auto& values : frames) session.Record(values);
    session.GoTo(1);
    session.Record(frames[3]);
  }
  const std::filesystem::path curves = folder_ / "curves.json";
  last_write_time(curves, last_write_time(curves) - std::chrono::hours(1));
  const auto written = last_write_time(curves);
  RecordingSession session(theropod_, folder_, {});
  EXPECT_EQ(last_write_time(curves), written);  // what was baked of it is not out of date
  EXPECT_EQ(session.frame_count(), 4);
  EXPECT_EQ(session.at(), 2);
  EXPECT_EQ(session.frames()[1], frames[3]);
  EXPECT_EQ(session.frames()[2], frames[2]);
  EXPECT_EQ(ParseCurvesJson(ReadFile(folder_ / "curves.json"), "c", theropod_).values,
            session.Curves().values);
  session.CutHere();
  EXPECT_EQ(session.frame_count(), 2);
  session.GoTo(99);
  EXPECT_EQ(session.at(), 2);
  session.GoTo(-5);
  EXPECT_EQ(session.at(), 0);
}

TEST_F(Session, SurvivesItsJournalCutOffAtAnyByte) {
  const auto frames = Frames(theropod_, 3);
  {
    RecordingSession session(theropod_, folder_, {});
    for (const auto& values : frames) session.Record(values);
  }
  const std::string whole = Journal();
  for (std::size_t length = 0; length <= whole.size(); length += 97) {
    WriteFile(folder_ / "journal.jsonl", whole.substr(0, length));
    RecordingSession session(theropod_, folder_, {});
    const std::string kept = whole.substr(0, length);
    const auto lines = std::count(kept.begin(), kept.end(), '\n');
    ASSERT_EQ(session.frame_count(), std::max<std::ptrdiff_t>(0, lines - 1)) << length;
    while (session.frame_count() < 3)
      session.Record(frames[static_cast<std::size_t>(session.frame_count())]);
    ASSERT_EQ(session.frames(), frames) << length;
  }
}

TEST_F(Session, DoesNotReplaceATakeThatWasEdited) {
  const std::string edited = CurvesJson(theropod_, Walk(theropod_, 3, 1));
  WriteFile(folder_ / "curves.json", edited);
  try {
    RecordingSession session(theropod_, folder_, {});
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("a take that was edited"));
  }
  EXPECT_EQ(ReadFile(folder_ / "curves.json"), edited);
}

TEST_F(Session, IsLockedWhileItIsOpen) {
  RecordingSession session(theropod_, folder_, {});
  EXPECT_THROW(RecordingSession(theropod_, folder_, {}), LockedError);
}

TEST_F(Session, OfAnotherRateOrArmatureOrDamagedIsAFault) {
  { RecordingSession session(theropod_, folder_, {}); }
  EXPECT_THROW(RecordingSession(theropod_, folder_, {25, 1}), InputError);
  Armature other = theropod_;
  other.nodes[static_cast<std::size_t>(other.joints[5])].name = "else";
  try {
    RecordingSession session(other, folder_, {});
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("the session has no joint 'else', but '"));
    EXPECT_THAT(error.what(), HasSubstr("if that was renamed"));
  }
  WriteFile(folder_ / "journal.jsonl", Journal() + "{\"record\":5,\"values\":[]}\n");
  try {
    RecordingSession session(theropod_, folder_, {});
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("journal.jsonl, line 2: it does not fit"));
  }
}

}  // namespace keypose::armature::recording_test
