#include "interpolate/timing/frame_schedule.h"

#include <gtest/gtest.h>

#include "core/io/project/timeline_json.h"
#include "core/values/errors.h"
#include "interpolate/timing/easing.h"

namespace keypose::interpolation::frame_schedule_test {

Schedule FromText(const std::string& text, int keys, int steps = 9) {
  return MakeSchedule(ParseTimeline(text, "timeline.json"), keys, steps, "timeline.json");
}

TEST(MakeSchedule, RoundsTimesToFrames) {
  const Schedule s = FromText(
      R"({"schema":1,"fps":24,"keys":[{"pose":"a","time":3},{"pose":"b","time":3.51},{"pose":"a","time":4.5}]})",
      3);
  EXPECT_EQ(s.key_frames, (std::vector<int>{0, 12, 36}));
  EXPECT_EQ(s.frames.size(), 37u);
  EXPECT_NEAR(s.frames[6].way, 0.5, 1e-15);
  EXPECT_EQ(s.frames[12].key, 1);
  EXPECT_EQ(s.frames[36].key, 2);
  EXPECT_NEAR(s.frames[6].time_s, 3.25, 1e-12);
}

TEST(MakeSchedule, WithoutTimesStepsLieBetweenKeysAndHoldsComeOnTop) {
  const Schedule s = FromText(R"({"fps":10,"keys":[{"hold":0.3},{},{"hold":0.2}]})", 3, 4);
  EXPECT_EQ(s.key_frames, (std::vector<int>{0, 8, 13}));
  EXPECT_EQ(s.frames.size(), 16u);
  for (int f = 1; f <= 3; ++f) EXPECT_EQ(s.frames[f].same_as, 0);
  EXPECT_NEAR(s.frames[4].way, 0.2, 1e-15);
  EXPECT_EQ(s.frames[15].same_as, 13);
}

TEST(MakeSchedule, EveryKeyShowsAtItsOwnFrameOnTwosToo) {
  const Schedule s =
      FromText(R"({"fps":10,"step":2,"keys":[{"time":0},{"time":0.5},{"time":1.2}]})", 3);
  for (const int f : s.key_frames) EXPECT_GE(s.frames[f].key, 0);
  const std::vector<int> shown = {-1, 0, -1, 2, -1, -1, 5, -1, 7, -1, 9, -1, -1};
  for (std::size_t f = 0; f < shown.size(); ++f) EXPECT_EQ(s.frames[f].same_as, shown[f]) << f;
}

TEST(MakeSchedule, SaysWhichPicturesStandUntilTheNext) {
  const auto stands = [](const Schedule& s) {
    std::string text;
    for (const PlannedFrame& frame : s.frames) text += frame.stands ? '1' : '0';
    return text;
  };
  // After a hold, motion on ones continues from the end of the hold; on twos and stepped, every
  // picture stays until the next.
  EXPECT_EQ(stands(FromText(R"({"fps":10,"keys":[{"time":0,"hold":0.2},{"time":0.5}]})", 2)),
            "000000");
  EXPECT_EQ(
      stands(FromText(
          R"({"fps":10,"keys":[{"time":0,"hold":0.2,"step":2},{"time":0.5},{"time":0.7}]})", 3)),
      "00111000");
  EXPECT_EQ(
      stands(FromText(
          R"({"fps":10,"keys":[{"time":0,"interpolation":"stepped"},{"time":0.3},{"time":0.5}]})",
          3)),
      "111000");
  // Held until the next key: the pictures of a hold are equal, so only the change after its last
  // frame is a step.
  EXPECT_EQ(
      stands(FromText(R"({"fps":10,"keys":[{"time":0,"hold":0.3},{"time":0.3},{"time":0.5}]})", 3)),
      "001000");
}

TEST(MakeSchedule, EasesMoveOnlyTheWay) {
  const Schedule s = FromText(R"({"fps":10,"ease":"in","keys":[{"time":0},{"time":1}]})", 2);
  EXPECT_NEAR(s.frames[5].way, EaseAt(EaseNamed("in").value(), 0.5), 1e-15);
  EXPECT_EQ(s.frames[10].way, 1);
}

TEST(MakeSchedule, NamesTheKeyThatDoesNotFit) {
  EXPECT_THROW(FromText(R"({"fps":24,"keys":[{"time":0},{"time":1}]})", 3), InputError);
  EXPECT_THROW(FromText(R"({"fps":24,"keys":[{"time":0},{"time":1e6}]})", 2), InputError);
  try {
    FromText(
        R"({"fps":24,"keys":[{"pose":"a","time":0},{"pose":"b","time":1},{"pose":"c","time":1.01}]})",
        3);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("key 2 ('c')"), std::string::npos);
  }
}

}  // namespace keypose::interpolation::frame_schedule_test
