#include "interpolate/timing/rules.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/io/project/timeline_json.h"
#include "core/surfaces/shapes.h"
#include "core/values/errors.h"
#include "interpolate/timing/frame_schedule.h"

namespace keypose::interpolation::rules_test {

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

}  // namespace keypose::interpolation::rules_test
