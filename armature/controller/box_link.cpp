#include "armature/controller/box_link.h"

#include <algorithm>

#include "armature/controller/steady_clock.h"

namespace keypose::armature {
namespace {

constexpr unsigned kHello = 0x01, kRead = 0x02, kChanges = 0x03, kReset = 0x04, kPreload = 0x05,
                   kFlags = 0x06, kReply = 0x80, kError = 0xFF;
constexpr unsigned kVersion = 1, kAllSensors = 0xFFFF;
constexpr std::size_t kMostPreloads = 64;

[[noreturn]] void Refused(unsigned kind, const WireFrame& reply) {
  static const char* const kWhy[] = {"for no known reason", "it does not know the request",
                                     "the request has a wrong length", "it has no such sensor"};
  const unsigned code = reply.payload.empty() ? 0 : static_cast<unsigned char>(reply.payload[0]);
  throw BoxFault("the controller refused request " + std::to_string(kind) + ": " +
                 kWhy[code < 4 ? code : 0]);
}

[[noreturn]] void CannotBeRead() {
  throw BoxFault("a reply of the controller is not of the form of version 1 of its protocol");
}

}  // namespace

std::vector<CardKind> BoxInfo::KindOfSensors() const {
  std::vector<CardKind> kinds;
  for (const BoxCard& card : cards)
    kinds.insert(kinds.end(), static_cast<std::size_t>(card.inputs), card.kind);
  kinds.resize(static_cast<std::size_t>(sensors), CardKind::kEncoders);
  return kinds;
}

BoxLink::BoxLink(ByteLine& line, const LinkOptions& options) : line_(line), options_(options) {}

WireFrame BoxLink::Ask(unsigned kind, const std::string& payload) {
  const WireFrame request{static_cast<std::uint8_t>(kind), ++seq_, payload};
  const std::string bytes = EncodeFrame(request);
  for (int attempt = 0; attempt < options_.tries; ++attempt) {
    if (attempt > 0) ++repeats_;
    line_.Write(bytes);
    const double until = SteadySeconds() + options_.reply_s;
    while (true) {
      while (const auto reply = reader_.Next()) {
        if (reply->seq != request.seq) continue;  // of an earlier request, too late
        if (reply->kind == (kind | kReply)) return *reply;
        if (kind == kChanges && reply->kind == (kRead | kReply)) return *reply;
        if (reply->kind == kError) Refused(kind, *reply);
      }
      const double left = until - SteadySeconds();
      if (left <= 0) break;
      reader_.Push(line_.Read(left));
    }
  }
  throw BoxFault("the controller is silent: " + std::to_string(options_.tries) +
                 " requests had no answer");
}

const BoxInfo& BoxLink::Greet() {
  reader_.Clear();
  has_read_ = false;
  const WireFrame reply = Ask(kHello, "");
  PayloadReader reader(reply.payload);
  const unsigned version = reader.U8();
  if (reader.fine() && version != kVersion)
    throw BoxFault("the controller speaks version " + std::to_string(version) +
                   " of its protocol, and this program version 1");
  BoxInfo info;
  info.boot = static_cast<int>(reader.U16());
  info.sensors = static_cast<int>(reader.U16());
  const unsigned cards = reader.U8();
  for (unsigned c = 0; c < cards && reader.fine(); ++c) {
    BoxCard card;
    card.kind = reader.U8() == 2 ? CardKind::kAnalogue : CardKind::kEncoders;
    card.inputs = static_cast<int>(reader.U8());
    info.cards.push_back(card);
  }
  if (!reader.fine() || !reader.at_end()) CannotBeRead();
  info_ = info;
  counts_.assign(static_cast<std::size_t>(info.sensors), 0);
  return info_;
}

bool BoxLink::Update() {
  std::string payload;
  PutU16(&payload, static_cast<unsigned>(info_.boot));
  PutU16(&payload, mark_);
  const WireFrame reply = has_read_ ? Ask(kChanges, payload) : Ask(kRead, "");
  PayloadReader reader(reply.payload);
  if (static_cast<int>(reader.U16()) != info_.boot) return false;
  mark_ = reader.U16();
  alarm_ = reader.U8() != 0;
  if (reply.kind == (kRead | kReply))
    TakeAll(reader);
  else
    TakeChanges(reader);
  has_read_ = true;
  return true;
}

void BoxLink::TakeAll(PayloadReader reader) {
  const unsigned count = reader.U16();
  if (count != counts_.size()) CannotBeRead();
  std::vector<std::int32_t> counts;
  for (unsigned s = 0; s < count; ++s) counts.push_back(reader.U24());
  if (!reader.fine() || !reader.at_end()) CannotBeRead();
  counts_ = std::move(counts);
}

void BoxLink::TakeChanges(PayloadReader reader) {
  const unsigned count = reader.U16();
  std::vector<std::int32_t> counts = counts_;
  for (unsigned i = 0; i < count && reader.fine(); ++i) {
    const unsigned sensor = reader.U16();
    const std::int32_t value = reader.U24();
    if (sensor >= counts.size()) CannotBeRead();
    counts[sensor] = value;
  }
  if (!reader.fine() || !reader.at_end()) CannotBeRead();
  counts_ = std::move(counts);
}

std::vector<unsigned> BoxLink::ReadFlags() {
  const WireFrame reply = Ask(kFlags, "");
  PayloadReader reader(reply.payload);
  reader.U16();
  const unsigned count = reader.U16();
  std::vector<unsigned> flags;
  for (unsigned s = 0; s < count && reader.fine(); ++s) flags.push_back(reader.U8());
  if (!reader.fine() || flags.size() != counts_.size()) CannotBeRead();
  return flags;
}

void BoxLink::Reset(int sensor) {
  std::string payload;
  PutU16(&payload, sensor < 0 ? kAllSensors : static_cast<unsigned>(sensor));
  Ask(kReset, payload);
}

void BoxLink::Preload(const std::vector<std::pair<int, std::int32_t>>& counts) {
  for (std::size_t begin = 0; begin < counts.size(); begin += kMostPreloads) {
    const std::size_t end = std::min(counts.size(), begin + kMostPreloads);
    std::string payload;
    PutU16(&payload, static_cast<unsigned>(end - begin));
    for (std::size_t i = begin; i < end; ++i) {
      PutU16(&payload, static_cast<unsigned>(counts[i].first));
      PutI24(&payload, counts[i].second);
    }
    Ask(kPreload, payload);
  }
}

}  // namespace keypose::armature
