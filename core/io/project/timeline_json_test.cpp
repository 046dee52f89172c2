#include "core/io/project/timeline_json.h"

#include <gtest/gtest.h>

namespace keypose::timeline_test {

Timeline Parse(const std::string& text) { return ParseTimeline(text, "timeline.json"); }

/// A timeline of two keys with `field` added to the second one, or `top` at the top level.
std::string WithKey(const std::string& field) {
  return R"({"schema":2,"fps":24,"regions":[{"name":"leg","vertices":[0,1]}],"keys":[{"pose":"rest","time":0},{"pose":"up","time":1)" +
         field + "}]}";
}
std::string WithTop(const std::string& top) {
  return R"({"schema":2,"fps":24,)" + top +
         R"(,"keys":[{"pose":"rest","time":0},{"pose":"up","time":1}]})";
}

std::string Complaint(const std::string& text) {
  try {
    Parse(text);
  } catch (const TimelineError& error) {
    return error.what();
  }
  return "";
}

TEST(ParseTimeline, ReadsEveryField) {
  const Timeline t = Parse(
      R"({"schema":2,"fps":12.5,"loop":true,"overshoot":true,"interpolation":"linear","ease":"in","step":2,"table":-0.5,
    "volume":[{"time":0.5,"ratio":0.8}],
    "regions":[{"name":"foot","vertices":[3,4]},{"name":"hand","center":[1,2,3],"radius":0.25}],
    "pins":[{"region":"foot","from":0,"to":1}],
    "trajectories":[{"region":"hand","points":[{"time":0.5,"at":[1,0,2]}]}],
    "keys":[{"pose":"a","time":0,"hold":0.25,"ease":[0.1,-1,0.9,2],"interpolation":"stepped","step":1,"turns":{"hand":-1,"foot":{"turns":2,"axis":[0,0,1]}}},
            {"pose":"b","time":1},{"pose":"a","time":2}]})");
  EXPECT_EQ(t.fps, 12.5);
  EXPECT_TRUE(t.loop && t.overshoot && t.keep_volume.value());
  EXPECT_EQ(t.table_height.value(), -0.5);
  EXPECT_EQ(t.volume.at(0).ratio, 0.8);
  EXPECT_EQ(t.FindRegion("foot")->vertices, (std::vector<int>{3, 4}));
  EXPECT_EQ(t.FindRegion("hand")->center, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(t.pins.at(0).to_s.value(), 1);
  EXPECT_EQ(t.trajectories.at(0).points.at(0).at.z(), 2);
  ASSERT_EQ(t.keys.size(), 3u);
  EXPECT_EQ(t.keys[0].hold_s, 0.25);
  EXPECT_EQ(t.keys[0].ease, (Ease{0.1, -1, 0.9, 2}));
  EXPECT_EQ(t.keys[0].travel, Travel::kStepped);
  EXPECT_EQ(t.keys[0].step, 1);
  EXPECT_EQ(t.keys[0].turns.at("hand").turns, -1);
  EXPECT_EQ(t.keys[0].turns.at("foot"), (TimelineTurn{2, {0, 0, 1}}));
  EXPECT_EQ(t.keys[1].travel, Travel::kLinear);
  EXPECT_EQ(t.keys[1].ease, EaseNamed("in").value());
  EXPECT_EQ(t.keys[1].step, 2);
}

TEST(ParseTimeline, SchemaOneIsReadAsBeforeAndKnowsNothingElse) {
  const Timeline t =
      Parse(R"({"schema":1,"fps":24,"keys":[{"pose":"a","time":0},{"pose":"b","time":0.5}]})");
  EXPECT_EQ(t.keys[1].time_s.value(), 0.5);
  EXPECT_EQ(t.keys[0].travel, Travel::kSmooth);
  EXPECT_TRUE(t.keys[0].ease.even());
  EXPECT_NE(
      Complaint(
          R"({"schema":1,"fps":24,"keys":[{"pose":"a","time":0,"hold":1},{"pose":"b","time":2}]})")
          .find("no field 'hold'"),
      std::string::npos);
  EXPECT_NE(Complaint(R"({"schema":3,"fps":24,"keys":[]})").find("update"), std::string::npos);
}

TEST(ParseTimeline, KeysMayHaveNoTimesButAllOrNone) {
  EXPECT_FALSE(
      Parse(R"({"schema":2,"fps":24,"keys":[{"pose":"a","hold":1},{"pose":"b"}]})").has_times());
  EXPECT_NE(Complaint(R"({"schema":2,"fps":24,"keys":[{"pose":"a"},{"pose":"b","time":1}]})")
                .find("key 1 ('b'): field 'time'"),
            std::string::npos);
}

TEST(ParseTimeline, NamesKeyAndFieldAndTheNearestKnownOne) {
  EXPECT_EQ(Complaint(WithKey("")), "");
  EXPECT_EQ(Complaint(WithKey(R"(,"eas":"in")")),
            "timeline.json: key 1 ('up') has no field 'eas'; did you mean 'ease'?");
  EXPECT_EQ(Complaint(WithTop(R"("lop":true)")),
            "timeline.json has no field 'lop'; did you mean 'loop'?");
  for (const auto& [field, words] : std::map<std::string, std::string>{
           {R"(,"ease":"inn")", "key 1 ('up'): field 'ease' is 'inn'"},
           {R"(,"ease":[0,0,1])", "key 1 ('up'): field 'ease' is [0,0,1]"},
           {R"(,"ease":[1.2,0,1,1])", "time would run backwards"},
           {R"(,"interpolation":"cubic")", "stepped, linear or smooth"},
           {R"(,"hold":-1)", "key 1 ('up'): field 'hold' is -1"},
           {R"(,"hold":"long")", "must be a number"},
           {R"(,"step":1.5)", "key 1 ('up'): field 'step' is 1.5, but it must be a whole number"},
           {R"(,"step":0)", "field 'step'"},
           {R"(,"turns":{"leg":0.5})", "key 1 ('up'): field 'turns'"},
           {R"(,"turns":{"leg":{"turns":1,"axle":[0,0,1]}})",
            "turns of 'leg' has no field 'axle'; did you mean 'axis'?"},
           {R"(,"turns":{"leg":{"axis":[0,0,1]}})", "give no number of turns"},
           {R"(,"turns":{"lek":1})",
            "names the region 'lek', which is not among `regions`; did you mean 'leg'?"}})
    EXPECT_NE(Complaint(WithKey(field)).find(words), std::string::npos)
        << field << " gives: " << Complaint(WithKey(field));
}

TEST(ParseTimeline, RefusesWhatCannotBe) {
  for (const std::string& text :
       {std::string("not json"), std::string("[]"), std::string(R"({"fps":24})"),
        std::string(R"({"keys":[{"time":0},{"time":1}]})"),
        std::string(R"({"fps":0,"keys":[{"time":0},{"time":1}]})"),
        std::string(R"({"fps":24,"keys":[{"time":0}]})"),
        std::string(R"({"fps":24,"keys":[{"time":1},{"time":0}]})"),
        std::string(R"({"fps":24,"keys":[{"time":0},7]})"),
        std::string(R"({"fps":24,"keys":[{"time":0,"hold":2},{"time":1}]})"),
        WithTop(R"("regions":[{"name":"a"}])"),
        WithTop(R"("regions":[{"name":"a","vertices":[-1]}])"),
        WithTop(R"("regions":[{"center":[0,0,0],"radius":1}])"),
        WithTop(R"("pins":[{"region":"nothing"}])"),
        WithTop(R"("trajectories":[{"region":"x","points":[]}])"),
        WithTop(R"("volume":[{"time":1,"ratio":0}])"), WithTop(R"("volume":"much")"),
        WithTop(R"("table":"low")")})
    EXPECT_THROW(Parse(text), TimelineError) << text;
}

TEST(ParseTimeline, ErrorsSayWhichKey) {
  try {
    Parse(R"({"fps":24,"keys":[{"time":0},{"time":1,"hold":3},{"time":2}]})");
    FAIL();
  } catch (const TimelineError& error) {
    EXPECT_EQ(error.key, 1);
  }
}

TEST(ParseTimeline, AHoldMayEndAtTheNextKeyWhateverBinaryNumbersSay) {
  const Timeline t =
      Parse(R"({"fps":10,"keys":[{"time":0.1,"hold":0.2},{"time":0.3},{"time":0.7}]})");
  EXPECT_EQ(t.keys[0].hold_s, 0.2);
  EXPECT_NE(Complaint(R"({"fps":10,"keys":[{"time":0.1,"hold":0.21},{"time":0.3}]})")
                .find("field 'hold' is 0.21 s, but the next key comes 0.2 s later"),
            std::string::npos);
}

/// What is wrong with a timeline of three keys, of which `text` is the rest.
std::string Obstacle(const std::string& text) {
  try {
    RequirePlayable(Parse(R"({"fps":12,"regions":[{"name":"leg","vertices":[0,1]}],)" + text + "}"),
                    "timeline");
  } catch (const TimelineError& error) {
    return error.what();
  }
  return "";
}

TEST(RequirePlayable, ALoopEndsWithItsFirstPose) {
  const std::string loop = R"("loop":true,"keys":[{"pose":"rest"},{"pose":"wave"})";
  EXPECT_EQ(Obstacle(loop + R"(,{"pose":"rest"}])"), "");
  EXPECT_EQ(Obstacle(loop + "]"),
            "timeline: the timeline loops, but it begins with pose 'rest' and ends with 'wave'; "
            "end it with 'rest' again, at the time when the loop closes");
}

TEST(RequirePlayable, KeysAreAFrameApart) {
  EXPECT_EQ(Obstacle(R"("keys":[{"time":1},{"time":1.05}])"), "") << "0.6 of a frame is the next";
  EXPECT_EQ(Obstacle(R"("keys":[{"pose":"a","time":1},{"pose":"b","time":1.04}])"),
            "timeline: key 1 ('b') is in the same frame as the key before it: 1 s and 1.04 s at 12 "
            "frames a second; move it by a frame or more");
}

TEST(RequirePlayable, PinsGoFromKeyToKeyOrFromAHold) {
  const std::string keys = R"(,"keys":[{"time":1,"hold":0.5},{"time":2},{"time":3}])";
  EXPECT_EQ(Obstacle(R"("pins":[{"region":"leg","from":1.5,"to":3}])" + keys), "");
  EXPECT_EQ(Obstacle(R"("pins":[{"region":"leg"}])" + keys), "");
  EXPECT_NE(Obstacle(R"("pins":[{"region":"leg","from":1,"to":2.5}])" + keys)
                .find("the pin of 'leg' begins or ends at 2.5 s, where no key is"),
            std::string::npos);
}

}  // namespace keypose::timeline_test
