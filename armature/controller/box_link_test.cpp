#include "armature/controller/box_link.h"

#include <gtest/gtest.h>

#include <random>
#include <utility>

#include "armature/firmware/testing/box_bench.h"

namespace keypose::armature::box_link_test {

const LinkOptions kHasty{0.001, 60};

TEST(BoxLink, LearnsTheBoxesCards) {
  DirectLine line(74);
  line.cards[4].kind = keypose_box::kAnalogue;
  BoxLink link(line);
  const BoxInfo& info = link.Greet();
  EXPECT_EQ(info.boot, 1);
  EXPECT_EQ(info.sensors, 74);
  ASSERT_EQ(info.cards.size(), 5u);
  EXPECT_EQ(info.cards[0].inputs, 16);
  EXPECT_EQ(info.cards[4].inputs, 10);
  EXPECT_EQ(info.KindOfSensors()[63], CardKind::kEncoders);
  EXPECT_EQ(info.KindOfSensors()[64], CardKind::kAnalogue);
}

TEST(BoxLink, ReadsAllOnceAndThenChangesOnly) {
  DirectLine line(74);
  BoxLink link(line);
  link.Greet();
  line.bench.counts[73] = -5;
  ASSERT_TRUE(link.Update());
  EXPECT_EQ(link.counts()[73], 0xFFFFFB);
  EXPECT_EQ(line.last_reply, 8 + 7 + 3 * 74u);
  ASSERT_TRUE(link.Update());
  EXPECT_EQ(line.last_reply, 8 + 7u);
  line.bench.counts[3] = 77;
  ASSERT_TRUE(link.Update());
  EXPECT_EQ(line.last_reply, 8 + 7 + 5u);
  EXPECT_EQ(link.counts()[3], 77);
  EXPECT_EQ(link.counts()[73], 0xFFFFFB);
}

TEST(BoxLink, GetsAllWhenThatIsShorter) {
  DirectLine line(74);
  BoxLink link(line);
  link.Greet();
  link.Update();
  for (int s = 0; s < 44; ++s) line.bench.counts[s] = s + 1;
  ASSERT_TRUE(link.Update());
  EXPECT_EQ(line.last_reply, 8 + 7 + 5 * 44u);
  for (int s = 0; s < 45; ++s) line.bench.counts[s] = s + 2;
  ASSERT_TRUE(link.Update());
  EXPECT_EQ(line.last_reply, 8 + 7 + 3 * 74u);
  EXPECT_EQ(link.counts(), line.bench.counts);
}

TEST(BoxLink, ChangesOfALostReplyComeWithTheNext) {
  DirectLine line(20);
  BoxLink link(line, kHasty);
  link.Greet();
  link.Update();
  line.bench.counts[4] = 9;
  line.lose_replies = 1;
  ASSERT_TRUE(link.Update());
  EXPECT_EQ(link.repeats(), 1);
  EXPECT_EQ(link.counts()[4], 9);
}

TEST(BoxLink, SurvivesMarksThatWrap) {
  DirectLine line(4);
  BoxLink link(line);
  link.Greet();
  std::mt19937 random(2);
  for (int i = 0; i < 140000; ++i) {  // two rounds of the mark
    if (random() % 50 == 0)
      line.bench.counts[random() % 3] = static_cast<std::int32_t>(random() % 1000);
    ASSERT_TRUE(link.Update());
    for (int s = 0; s < 4; ++s) ASSERT_EQ(link.counts()[s], line.bench.counts[s]) << i;
  }
}

TEST(BoxLink, NoDamageOnTheLineEverShowsAsACount) {
  DirectLine line(74);
  BoxLink link(line, kHasty);
  link.Greet();
  link.Update();
  line.damage = 0.02;
  std::mt19937 random(4);
  for (int i = 0; i < 600; ++i) {
    for (int k = 0; k < 3; ++k)
      line.bench.counts[random() % 74] = static_cast<std::int32_t>(random() & 0xFFFFFF);
    ASSERT_TRUE(link.Update());
    ASSERT_EQ(link.counts(), line.bench.counts) << i;
  }
  EXPECT_GT(link.damaged(), 100);
  EXPECT_GT(link.repeats(), 100);
}

TEST(BoxLink, TellsOfAPowerUp) {
  DirectLine line(4);
  BoxLink link(line);
  link.Greet();
  EXPECT_TRUE(link.Update());
  line.Restart(2);
  EXPECT_FALSE(link.Update());
  EXPECT_EQ(link.Greet().boot, 2);
  EXPECT_TRUE(link.Update());
}

TEST(BoxLink, RepeatedResetIsCarriedOutOnce) {
  DirectLine line(4);
  BoxLink link(line, kHasty);
  link.Greet();
  line.lose_replies = 3;
  link.Reset(-1);
  EXPECT_EQ(line.bench.sets, 4);
  EXPECT_EQ(link.repeats(), 3);
  link.Reset(-1);
  EXPECT_EQ(line.bench.sets, 8);
}

TEST(BoxLink, PreloadsAsManyAsThereAre) {
  DirectLine line(150);
  BoxLink link(line);
  link.Greet();
  std::vector<std::pair<int, std::int32_t>> wanted;
  for (int s = 0; s < 150; ++s) wanted.emplace_back(s, -1000 * s);
  link.Preload(wanted);
  link.Update();
  for (int s = 0; s < 150; ++s) EXPECT_EQ(link.counts()[s], (-1000 * s) & 0xFFFFFF);
}

TEST(BoxLink, RefusalsAndSilenceAreFaults) {
  DirectLine line(4);
  BoxLink link(line, kHasty);
  link.Greet();
  EXPECT_THROW(link.Reset(4), BoxFault);
  EXPECT_THROW(link.Preload({{0, 1}, {9, 1}}), BoxFault);
  EXPECT_EQ(line.bench.sets, 0);
  line.damage = 1;
  EXPECT_THROW(link.Update(), BoxFault);
}

TEST(BoxLink, ReadsFlagsWhenThereIsAnAlarm) {
  DirectLine line(20);
  BoxLink link(line);
  link.Greet();
  link.Update();
  EXPECT_FALSE(link.alarm());
  line.bench.flags[17] = keypose_box::kNoSignal;
  link.Update();
  EXPECT_TRUE(link.alarm());
  EXPECT_EQ(link.ReadFlags()[17], kFlagNoSignal);
}

}  // namespace keypose::armature::box_link_test
