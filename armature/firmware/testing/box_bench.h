// A box on a line that the tests may disturb.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <random>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "armature/controller/box_link.h"
#include "armature/firmware/keypose_box.h"

namespace keypose::armature {

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

}  // namespace keypose::armature
