// Requests to the controller box and its replies, over a line that may lose or damage bytes.
#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "armature/controller/wire_frame.h"

namespace keypose::armature {

/// A line of bytes, such as a serial port. Either function throws what its port throws.
class ByteLine {
 public:
  virtual ~ByteLine() = default;
  virtual void Write(std::string_view bytes) = 0;
  /// What has come; "" if nothing did in time.
  virtual std::string Read(double timeout_s) = 0;
};

/// The box did not answer a request, though it was repeated, or refused it.
struct BoxFault : std::runtime_error {
  using std::runtime_error::runtime_error;
};

enum class CardKind { kEncoders = 1, kAnalogue = 2 };

struct BoxCard {
  CardKind kind = CardKind::kEncoders;
  int inputs = 0;
};

struct BoxInfo {
  int boot = 0;  ///< another number after each power-up of the box
  int sensors = 0;
  std::vector<BoxCard> cards;  ///< sensors are numbered through, card after card
  /// The kind of each sensor's card.
  std::vector<CardKind> KindOfSensors() const;
};

/// What is wrong with a sensor, by the box: bits of its flags.
inline constexpr unsigned kFlagLostCount = 1, kFlagNoSignal = 2;

struct LinkOptions {
  double reply_s = 0.1;  ///< wait for a reply [s], > 0
  int tries = 5;         ///< requests until the box counts as silent, >= 1
};

/// Keeps an image of all counters. Each function throws BoxFault, or what the line throws.
class BoxLink {
 public:
  explicit BoxLink(ByteLine& line, const LinkOptions& options = {});

  /// Must be called first, and after a fault.
  /// @throws BoxFault  also if it speaks another version
  const BoxInfo& Greet();
  const BoxInfo& info() const { return info_; }
  /// Reads the counters that have changed since the last reading; all, if there was none.
  /// @return whether the box is still the one that was greeted: false after a power-up, when it
  /// must be greeted again
  bool Update();
  /// The low 24 bits of each counter, as last read.
  const std::vector<std::int32_t>& counts() const { return counts_; }
  /// Whether some sensor's flags were set at the last reading.
  bool alarm() const { return alarm_; }
  std::vector<unsigned> ReadFlags();
  /// Sets counters to 0.
  /// @param sensor  -1: all
  void Reset(int sensor);
  void Preload(const std::vector<std::pair<int, std::int32_t>>& counts);

  /// Requests that were repeated, replies that were damaged or came too late, so far.
  int repeats() const { return repeats_; }
  int damaged() const { return reader_.damaged(); }

 private:
  WireFrame Ask(unsigned kind, const std::string& payload);
  void TakeAll(PayloadReader reader);
  void TakeChanges(PayloadReader reader);

  ByteLine& line_;
  LinkOptions options_;
  WireFrameReader reader_;
  BoxInfo info_;
  std::uint8_t seq_ = 0;
  bool has_read_ = false, alarm_ = false;
  unsigned mark_ = 0;
  std::vector<std::int32_t> counts_;
  int repeats_ = 0;
};

}  // namespace keypose::armature
