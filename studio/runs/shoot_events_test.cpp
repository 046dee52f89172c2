#include "studio/runs/shoot_events.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace keypose::studio::shoot_events_test {

using nlohmann::json;

constexpr int kAngles = 24;

json Session(const std::string& pose) {
  return {{"event", "session"}, {"pose", pose}, {"photographs", json::object()}};
}

json Photograph(const std::string& name, int time = 0) {
  return {{"event", "photograph"}, {"photograph", name}, {"entry", {{"exposure", time}}}};
}

json State(const std::string& state, const std::string& next) {
  return {{"event", "state"}, {"state", state}, {"next", next}};
}

class ShootEvents : public ::testing::Test {
 protected:
  void Tell(const json& event) { KeepShootEvent(event.dump(), &kept_); }
  std::vector<json> Kept(const std::string& event) const {
    std::vector<json> found;
    for (const std::string& line : kept_)
      if (const json one = json::parse(line); one["event"] == event) found.push_back(one);
    return found;
  }
  std::vector<std::string> kept_;
};

TEST_F(ShootEvents, ALongSessionKeepsHowItBeganAndAllThatLanded) {
  Tell(Session("rest"));
  Tell(Photograph("r9_a000"));
  for (int i = 0; i < 1500; ++i) {
    const std::string name = fmt::format("r1_a{:03}", 15 * (i % kAngles));
    Tell(State("shooting", name));
    Tell(Photograph(name, i));
    Tell({{"event", "findings"}, {"photographs", {{"r9_a000", json::array({i})}}}});
    Tell({{"event", "fault"}, {"fault", "camera-gone"}, {"words", std::to_string(i)}});
    Tell({{"event", "recovered"}, {"fault", "camera-gone"}, {"words", "works again"}});
    Tell({{"event", "accepted"}, {"command", "shoot"}});
    Tell({{"event", "live"}, {"frame", i}});
  }
  EXPECT_EQ(json::parse(kept_.front()), Session("rest"));
  ASSERT_EQ(Kept("photograph").size(), kAngles + 1u);
  EXPECT_EQ(Kept("photograph").back(), Photograph("r1_a165", 1499));
  EXPECT_EQ(Kept("findings")[0]["photographs"]["r9_a000"], json::array({1499}));
  EXPECT_EQ(Kept("state"), std::vector<json>{State("shooting", "r1_a165")});
  EXPECT_EQ(kept_.size(), 1 + (kAngles + 1) + 4u) << "a state, findings, recovered, accepted";
}

TEST_F(ShootEvents, TheNextPoseBeginsAnew) {
  Tell(Session("rest"));
  Tell(Photograph("r1_a000"));
  Tell(Session("bent"));
  EXPECT_EQ(kept_, std::vector<std::string>{Session("bent").dump()});
}

TEST_F(ShootEvents, FindingsOfAPhotographThatWasShotAgainAreGone) {
  Tell({{"event", "findings"}, {"photographs", {{"a", {1}}, {"b", {2}}}}});
  Tell(Photograph("a"));
  ASSERT_EQ(Kept("findings").size(), 1u);
  EXPECT_EQ(Kept("findings")[0]["photographs"], json({{"b", {2}}}));
  Tell(Photograph("b"));
  EXPECT_TRUE(Kept("findings").empty());
}

TEST_F(ShootEvents, WhatWasLeftOutIsNamedUntilItIsShot) {
  Tell(State("asking", "r1_a015"));
  Tell({{"event", "accepted"}, {"command", "skip"}});
  Tell(State("shooting", "r1_a030"));
  Tell({{"event", "accepted"}, {"command", "shoot"}});
  ASSERT_EQ(Kept("accepted").size(), 2u);
  EXPECT_EQ(Kept("accepted")[0]["id"], "r1_a015");
  Tell(Photograph("r1_a015"));
  EXPECT_EQ(Kept("accepted").size(), 1u);
}

}  // namespace keypose::studio::shoot_events_test
