#include "interpolate/timing/frame_schedule.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "core/io/project/timeline_json.h"
#include "core/surfaces/shapes.h"
#include "core/values/errors.h"
#include "interpolate/timing/easing.h"
#include "interpolate/timing/rules.h"
#include "interpolate/timing/spline.h"

namespace keypose::interpolation::timeline_test {

Schedule FromText(const std::string& text, int keys, int steps = 9) {
  return MakeSchedule(ParseTimeline(text, "timeline.json"), keys, steps, "timeline.json");
}

TEST(EaseAt, KnownCurvesAndExactEnds) {
  const Ease in_out = EaseNamed("in-out").value();
  EXPECT_EQ(EaseAt(in_out, 0), 0);
  EXPECT_EQ(EaseAt(in_out, 1), 1);
  EXPECT_NEAR(EaseAt(in_out, 0.5), 0.5, 1e-12);  // symmetric
  EXPECT_NEAR(EaseAt(in_out, 0.2) + EaseAt(in_out, 0.8), 1, 1e-12);
  EXPECT_LT(EaseAt(in_out, 0.1), 0.03);
  EXPECT_EQ(EaseAt({}, 0.3), 0.3);
  // With x(u) = u the curve is its own polynomial: y = 3 u (1-u)^2 y1 + 3 u^2 (1-u) y2 + u^3.
  const double u = 0.4;
  EXPECT_NEAR(EaseAt({1.0 / 3, 0.9, 2.0 / 3, 0.2}, u),
              3 * u * (1 - u) * (1 - u) * 0.9 + 3 * u * u * (1 - u) * 0.2 + u * u * u, 1e-12);
  EXPECT_LT(EaseAt({0.4, -0.8, 0.6, 1}, 0.2), 0);  // moves backwards first
}

TEST(EaseAt, SlopesAreTheDerivativesAtTheEnds) {
  const double h = 1e-6;
  for (const Ease& ease : {Ease{}, Ease{0.3, 0.1, 0.6, 0.8}, Ease{0.42, 0, 0.58, 1},
                           Ease{0, 0, 0.5, 0.7}, Ease{0.2, 0.3, 1, 1}}) {
    EXPECT_NEAR(SlopeAtStart(ease), EaseAt(ease, h) / h, 1e-3);
    EXPECT_NEAR(SlopeAtEnd(ease), (1 - EaseAt(ease, 1 - h)) / h, 1e-3);
  }
}

TEST(VelocityAtKey, ClampedIsTheHarmonicMeanAndNeverSwingsBeyond) {
  EXPECT_NEAR(VelocityAtKey(1.0, 2.0, 1, 1, false), 2 / (1 / 1.0 + 1 / 2.0), 1e-12);
  EXPECT_EQ(VelocityAtKey(1.0, -2.0, 1, 1, false), 0);
  EXPECT_EQ(VelocityAtKey(0.0, 3.0, 1, 1, false), 0);
  EXPECT_NEAR(VelocityAtKey(1.0, 2.0, 1, 3, true), (3 * 1.0 + 1 * 2.0) / 4, 1e-12);
  EXPECT_EQ(VelocityAtKey(0.0, 3.0, 1, 1, true), 0);
}

TEST(VelocityAtKey, DoesNotDependOnTheBasisOrTheDirectionOfTime) {
  const Eigen::Vector3d a(1, 0.2, -0.3), b(0.7, 0.9, 0.1);
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(0.8, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  const Eigen::Vector3d v = VelocityAtKey(a, b, 2, 3, false);
  EXPECT_LT(
      (VelocityAtKey(Eigen::Vector3d(turn * a), Eigen::Vector3d(turn * b), 2, 3, false) - turn * v)
          .norm(),
      1e-14);
  EXPECT_LT((VelocityAtKey(Eigen::Vector3d(-b), Eigen::Vector3d(-a), 3, 2, false) + v).norm(),
            1e-14);
}

TEST(SpanSpline, IsStraightInOneSpanAndMonotoneThroughMany) {
  const Schedule one = MakeSchedule({9});
  const SpanSpline<double> straight(one, {1.0, 3.0});
  EXPECT_NEAR(straight.At(0, 0.3), 1.6, 1e-15);
  const Schedule three = MakeSchedule({9, 4, 9});
  const SpanSpline<double> rising(three, {0.0, 1.0, 1.1, 5.0});
  double before = -1;
  for (int span = 0; span < 3; ++span)
    for (int k = 0; k <= 50; ++k) {
      const double value = rising.At(span, k / 50.0);
      EXPECT_GE(value, before - 1e-12);
      before = value;
    }
  EXPECT_EQ(rising.At(1, 0), 1.0);
  const SpanSpline<double> still(three, {2.0, 0.3, 0.3, 1.0});
  for (const double way : {0.1, 0.5, 0.77})
    EXPECT_EQ(still.At(1, way), 0.3);  // between equal keys, to the bit
}

TEST(SpanSpline, PassesItsWaypointsWithoutAJumpOfPace) {
  const Schedule schedule = MakeSchedule({9, 9});
  const SpanSpline<double> spline(schedule, {0.0, 1.0, 2.0}, {{{0.5, 3.0}}, {}});
  EXPECT_NEAR(spline.At(0, 0.5), 3, 1e-14);
  const double h = 1e-6;
  EXPECT_NEAR((spline.At(0, 0.5) - spline.At(0, 0.5 - h)) / h,
              (spline.At(0, 0.5 + h) - spline.At(0, 0.5)) / h, 1e-4);
  EXPECT_NEAR((spline.At(0, 1) - spline.At(0, 1 - h)) / h, (spline.At(1, h) - spline.At(1, 0)) / h,
              1e-4);
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

class RulesTest : public ::testing::Test {
 protected:
  Rules Read(const std::string& rest) const {
    const Timeline timeline = ParseTimeline(
        R"({"fps":10,"keys":[{"time":0,"turns":{"leg":1}},{"time":1,"hold":0.2},{"time":2,"interpolation":"stepped"},
        {"time":3}],"regions":[{"name":"leg","vertices":[0,1,2,12,13,14]},{"name":"top","center":[0,0,2],"radius":0.2}])" +
            rest + "}",
        "timeline.json");
    return RulesFrom(timeline, MakeSchedule(timeline, 4, 9, "timeline.json"), mesh_.points,
                     mesh_.faces, true, "timeline.json");
  }
  Mesh mesh_ = MakeCylinder(0.12, 2, 12, 30);
};

TEST_F(RulesTest, TakesRegionsPinsPathsAndVolumes) {
  const Rules rules = Read(
      R"(,"table":0.5,"volume":[{"time":0.5,"ratio":0.5}],"pins":[{"region":"leg","from":1.1,"to":2}],
      "trajectories":[{"region":"top","points":[{"time":0.25,"at":[1,2,3]},{"time":1.6,"at":[0,0,1]}]}])");
  EXPECT_EQ(rules.table_height.value(), 0.5);
  ASSERT_EQ(rules.held.size(), 2u);
  EXPECT_EQ(rules.held[0].spans, (std::vector<char>{0, 1, 0}));
  EXPECT_EQ(rules.held[1].spans, (std::vector<char>{1, 1, 0}));
  EXPECT_NEAR(rules.held[1].waypoints[0][0].way, 0.25, 1e-12);
  EXPECT_NEAR(rules.held[1].waypoints[1][0].way, 0.5, 1e-12);  // the hold does not count
  EXPECT_GT(rules.held[1].vertices.size(), 10u);
  EXPECT_NEAR(rules.log_volume[0][0].value, std::log(0.5), 1e-12);
  ASSERT_EQ(rules.turns[0].size(), 1u);
  EXPECT_EQ(rules.turns[0][0].extra_turns, 1);
  EXPECT_EQ(rules.turns[0][0].faces.size(), 4u);
  EXPECT_TRUE(rules.turns[1].empty());
}

TEST_F(RulesTest, RefusesWhatLiesNowhere) {
  EXPECT_THROW(Read(R"(,"pins":[{"region":"leg","from":0.5}])"), InputError);
  EXPECT_THROW(Read(R"(,"trajectories":[{"region":"top","points":[{"time":2.5,"at":[0,0,0]}]}])"),
               InputError);  // stepped
  EXPECT_THROW(Read(R"(,"trajectories":[{"region":"top","points":[{"time":1.1,"at":[0,0,0]}]}])"),
               InputError);  // held
  EXPECT_THROW(Read(R"(,"trajectories":[{"region":"top","points":[{"time":9,"at":[0,0,0]}]}])"),
               InputError);
  EXPECT_THROW(Read(R"(,"volume":[{"time":1,"ratio":0.5}])"), InputError);  // at a key
  const auto with_region = [&](const std::string& region) {
    const Timeline timeline = ParseTimeline(
        R"({"fps":10,"keys":[{"time":0},{"time":1}],"regions":[)" + region + "]}", "timeline.json");
    return RulesFrom(timeline, MakeSchedule(timeline, 2, 9, "t"), mesh_.points, mesh_.faces, true,
                     "timeline.json");
  };
  EXPECT_THROW(with_region(R"({"name":"a","vertices":[5000]})"), InputError);
  EXPECT_THROW(with_region(R"({"name":"a","center":[9,9,9],"radius":0.1})"), InputError);
}

}  // namespace keypose::interpolation::timeline_test
