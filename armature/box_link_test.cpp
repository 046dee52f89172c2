// The host's side of the protocol against the firmware's, on a line that can be made to fail.
#include "armature/controller/box_link.h"

#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <random>
#include <utility>

#include "armature/firmware/keypose_box.h"

namespace keypose::armature::box_link_test {

struct Bench final : keypose_box::Sensors, keypose_box::Line {
  explicit Bench(int sensors) : counts(sensors), flags(sensors) {}
  void Latch() override { ++latches; }
  std::int32_t Count(std::uint16_t sensor) override { return counts[sensor]; }
  void SetCount(std::uint16_t sensor, std::int32_t count) override {
    counts[sensor] = count;
    ++sets;
  }
  std::uint8_t Flags(std::uint16_t sensor) override { return flags[sensor]; }
  void Put(std::uint8_t byte) override { sent.push_back(static_cast<char>(byte)); }

  std::vector<std::int32_t> counts;
  std::vector<std::uint8_t> flags;
  std::string sent;
  int latches = 0, sets = 0;
};

/// Bytes go straight to the box and back, if they are not lost.
class DirectLine final : public ByteLine {
 public:
  explicit DirectLine(int sensors) : bench(sensors), cards(MakeCards(sensors)) { Restart(1); }
  void Restart(int boot) {
    box = std::make_unique<keypose_box::Box>(bench, bench, cards.data(),
                                             static_cast<std::uint8_t>(cards.size()),
                                             static_cast<std::uint16_t>(boot));
  }
  void Write(std::string_view bytes) override {
    box->LineIsQuiet();
    for (const char byte : Damaged(std::string(bytes))) box->Take(static_cast<std::uint8_t>(byte));
    last_reply = bench.sent.size();
    const std::string reply = std::exchange(bench.sent, {});
    if (!reply.empty() && lose_replies > 0)
      --lose_replies;
    else
      arrived += Damaged(reply);
  }
  std::string Read(double) override { return std::exchange(arrived, {}); }

  Bench bench;
  std::vector<keypose_box::Card> cards;
  std::unique_ptr<keypose_box::Box> box;
  double damage = 0;  ///< share of bytes that are changed or lost
  int lose_replies = 0;
  std::size_t last_reply = 0;

 private:
  static std::vector<keypose_box::Card> MakeCards(int sensors) {
    std::vector<keypose_box::Card> made;
    for (int left = sensors; left > 0; left -= 16)
      made.push_back({keypose_box::kEncoders, static_cast<std::uint8_t>(std::min(left, 16))});
    return made;
  }
  std::string Damaged(std::string bytes) {
    std::string result;
    for (const char byte : bytes) {
      const double luck = static_cast<double>(random_() % 100000) / 100000;
      if (luck < damage / 2) continue;
      result.push_back(luck < damage ? static_cast<char>(random_()) : byte);
    }
    return result;
  }
  std::string arrived;
  std::mt19937 random_{11};
};

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

TEST(Box, AnswersAreRefusalsWhereARequestIsOfAWrongForm) {
  DirectLine line(4);
  const auto reply_to = [&](const WireFrame& request) {
    line.Write(EncodeFrame(request));
    WireFrameReader reader;
    reader.Push(line.Read(0));
    return reader.Next();
  };
  for (const auto& [kind, payload] : std::map<int, std::string>{
           {0x01, "x"}, {0x02, "x"}, {0x03, "xxx"}, {0x04, "x"}, {0x05, "\x02"}, {0x06, "x"}}) {
    const auto reply = reply_to({static_cast<std::uint8_t>(kind), 1, payload});
    ASSERT_TRUE(reply) << kind;
    EXPECT_EQ(reply->kind, 0xFF) << kind;
    EXPECT_EQ(reply->payload, "\x02") << kind;
  }
  EXPECT_EQ(reply_to({0x33, 1, ""})->payload, "\x01");
}

TEST(Box, AnyBytesLeaveItWhole) {
  DirectLine line(74);
  std::mt19937 random(9);
  for (int i = 0; i < 300000; ++i)
    line.box->Take(static_cast<std::uint8_t>(random() % 7 ? random() : 0xA5));
  line.bench.sent.clear();
  BoxLink link(line);
  EXPECT_EQ(link.Greet().sensors, 74);
}

}  // namespace keypose::armature::box_link_test
