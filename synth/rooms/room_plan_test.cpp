#include "synth/rooms/room_plan.h"

#include <gtest/gtest.h>

#include <map>

#include "core/values/errors.h"
#include "synth/rooms/testing/small_room.h"

namespace keypose::synth::room_plan_test {

TEST(RoomPlans, TwentyFourSeedsHoldAllKindsInBalance) {
  std::map<std::string, int> kinds, seconds;
  int hands = 0, without_exif = 0;
  for (std::uint64_t seed = 1; seed <= 24; ++seed) {
    RoomOptions options;
    options.seed = seed;
    const RoomPlan plan = PlanRoom(options);
    EXPECT_TRUE(plan.free_standing());
    ++kinds[NameOf(plan.kind)], ++seconds[plan.second];
    hands += plan.hands > 0, without_exif += !plan.exif;
  }
  EXPECT_EQ(kinds, (std::map<std::string, int>{
                       {"walk", 6}, {"mat", 6}, {"mat-hand", 4}, {"both", 5}, {"one-side", 3}}));
  EXPECT_EQ(seconds["touching"], 6);
  EXPECT_GE(seconds["apart"], 3);
  EXPECT_GE(hands, 4);
  EXPECT_EQ(without_exif, 4);
}

TEST(RoomPlans, BadOptionsThrowUsageError) {
  const auto refuse = [](auto change) {
    RoomOptions options = Small("walk");
    change(options);
    EXPECT_THROW(PlanRoom(options), UsageError);
  };
  refuse([](RoomOptions& o) { o.kind = "garden"; });
  refuse([](RoomOptions& o) { o.photographs = 2; });
  refuse([](RoomOptions& o) { o.width = 3; });
  refuse([](RoomOptions& o) { o.second = "three"; });
  refuse([](RoomOptions& o) { o.exif = "maybe"; });
  refuse([](RoomOptions& o) { o.lenses = 3; });
  refuse([](RoomOptions& o) { o.hands = 7; });
  refuse([](RoomOptions& o) { o.detail = 0; });
  int width = 0, height = 0;
  ReadSize("640x480", &width, &height);
  EXPECT_EQ(width, 640);
  EXPECT_EQ(height, 480);
  for (const char* text : {"640", "640x", "x480", "640x480x3", "ax9"})
    EXPECT_THROW(ReadSize(text, &width, &height), UsageError) << text;
}

}  // namespace keypose::synth::room_plan_test
