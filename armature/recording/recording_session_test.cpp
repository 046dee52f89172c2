#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>

#include "armature/recording/joint_curves.h"
#include "armature/recording/recording_session.h"
#include "armature/recording/testing/walk.h"
#include "armature/testing/theropods.h"
#include "core/io/text/files.h"
#include "core/testing/folder.h"
#include "core/values/errors.h"

namespace keypose::armature::recording_session_test {

using ::testing::HasSubstr;

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

}  // namespace keypose::armature::recording_session_test
