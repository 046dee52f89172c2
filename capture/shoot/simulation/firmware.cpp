#include "capture/shoot/simulation/firmware.h"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace keypose::capture::shoot {

namespace fs = std::filesystem;

Firmware::Firmware(std::unique_ptr<Protocol> protocol, SimulatedWorld& world, FaultPlan& faults,
                   const fs::path& link, const FirmwareOptions& options)
    : protocol_(std::move(protocol)),
      world_(world),
      faults_(faults),
      link_(link),
      options_(options),
      boot_(options.boot) {
  terminal_.Open(link_);
  Send(protocol_->Reset(boot_));
  thread_ = std::thread([this] { Run(); });
}

Firmware::~Firmware() {
  ends_ = true;
  thread_.join();
  terminal_.Close();
  std::error_code ignored;
  fs::remove(link_, ignored);
}

void Firmware::Run() {
  using Seconds = std::chrono::duration<double>;
  auto last = std::chrono::steady_clock::now();
  while (!ends_) {
    const std::string received = terminal_.Read(0.002);
    const auto now = std::chrono::steady_clock::now();
    Serve(Seconds(now - last).count(), received);
    last = now;
  }
}

void Firmware::Serve(double passed_s, const std::string& received) {
  Turn(passed_s);
  mute_s_ = std::max(0.0, mute_s_ - passed_s);
  if (!terminal_.is_open()) {
    back_in_s_ -= passed_s;
    if (back_in_s_ <= 0) terminal_.Open(link_);
    return;
  }
  if (received.empty()) return;
  if (mute_s_ > 0) return;
  if (lose_lines_ > 0 && received.find('\n') != std::string::npos) {
    --lose_lines_;
    return;
  }
  std::string reply = protocol_->Receive(received, motor_);
  if (protocol_->moves > known_moves_) MakeFaults();
  Send(std::move(reply));
}

/// The faults that are planned for the move that was started just now.
void Firmware::MakeFaults() {
  known_moves_ = protocol_->moves;
  if (faults_.Due("lost-reply", known_moves_)) lose_replies_ = 2;
  if (faults_.Due("lost-line", known_moves_)) lose_lines_ = 2;
  if (faults_.Due("stall", known_moves_)) motor_.stalled = true;
  if (faults_.Due("mute", known_moves_)) mute_s_ = 1;
  unplug_in_mid_turn_ = faults_.Due("unplug", known_moves_);
  reset_in_mid_turn_ = faults_.Due("reset", known_moves_);
  if (faults_.Due("garbage", known_moves_)) Send("\xff<\x01garbage*00\n$ok<Idle|MP\n\n<7 OK\n");
}

void Firmware::Turn(double passed_s) {
  if (motor_.stalled || motor_.counted_deg == motor_.target_deg) return;
  const double before = motor_.counted_deg, way = motor_.target_deg - before;
  const double step = std::min(std::abs(way), options_.speed_deg_s * passed_s);
  motor_.counted_deg = step < std::abs(way) ? before + std::copysign(step, way) : motor_.target_deg;
  world_.SetTable(world_.table_deg() + motor_.counted_deg - before);
  if (unplug_in_mid_turn_) {
    unplug_in_mid_turn_ = false;
    back_in_s_ = options_.unplugged_s;
    terminal_.Close();
  }
  if (reset_in_mid_turn_) {
    reset_in_mid_turn_ = false;
    motor_ = {};
    Send(protocol_->Reset(++boot_));
  }
}

void Firmware::Send(std::string reply) {
  if (reply.empty()) return;
  if (lose_replies_ > 0) {
    --lose_replies_;
    return;
  }
  terminal_.Write(reply);
}

}  // namespace keypose::capture::shoot
