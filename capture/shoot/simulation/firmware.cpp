#include "capture/shoot/simulation/firmware.h"

#include <fcntl.h>
#include <poll.h>
#include <stdlib.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstring>

#include "core/errors.h"

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
  OpenPort();
  Send(protocol_->Reset(boot_));
  thread_ = std::thread([this] { Run(); });
}

Firmware::~Firmware() {
  ends_ = true;
  thread_.join();
  ClosePort();
  std::error_code ignored;
  fs::remove(link_, ignored);
}

void Firmware::OpenPort() {
  master_ = ::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC);
  char name[128];
  const bool fine = master_ >= 0 && ::grantpt(master_) == 0 && ::unlockpt(master_) == 0 &&
                    ::ptsname_r(master_, name, sizeof name) == 0;
  if (!fine)
    throw DiskError(std::string("no pseudo terminal for the simulated turntable: ") +
                    std::strerror(errno));
  // Else the terminal would send our own replies back to us before the host opens it.
  termios raw = {};
  tcgetattr(master_, &raw);
  cfmakeraw(&raw);
  tcsetattr(master_, TCSANOW, &raw);
  ::fcntl(master_, F_SETFL, O_NONBLOCK);
  const fs::path beside = link_.string() + ".new";
  std::error_code error;
  fs::remove(beside, error);
  fs::create_symlink(name, beside, error);
  if (!error) fs::rename(beside, link_, error);
  if (error) throw DiskError("cannot make " + link_.string() + ": " + error.message());
}

void Firmware::ClosePort() {
  if (master_ >= 0) ::close(master_);
  master_ = -1;
}

void Firmware::Run() {
  using Seconds = std::chrono::duration<double>;
  auto last = std::chrono::steady_clock::now();
  while (!ends_) {
    pollfd ready = {master_, POLLIN, 0};
    if (master_ >= 0 && ::poll(&ready, 1, 2) > 0 && (ready.revents & POLLHUP))
      ::usleep(2000);  // nobody has opened the port
    if (master_ < 0) ::usleep(2000);
    const auto now = std::chrono::steady_clock::now();
    Serve(Seconds(now - last).count());
    last = now;
  }
}

void Firmware::Serve(double passed_s) {
  Turn(passed_s);
  mute_s_ = std::max(0.0, mute_s_ - passed_s);
  if (master_ < 0) {
    back_in_s_ -= passed_s;
    if (back_in_s_ <= 0) OpenPort();
    return;
  }
  char bytes[256];
  const ssize_t count = ::read(master_, bytes, sizeof bytes);
  if (count <= 0) return;
  std::string received(bytes, static_cast<std::size_t>(count));
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
    ClosePort();
  }
  if (reset_in_mid_turn_) {
    reset_in_mid_turn_ = false;
    motor_ = {};
    Send(protocol_->Reset(++boot_));
  }
}

void Firmware::Send(std::string reply) {
  if (reply.empty() || master_ < 0) return;
  if (lose_replies_ > 0) {
    --lose_replies_;
    return;
  }
  while (!reply.empty()) {
    const ssize_t written = ::write(master_, reply.data(), reply.size());
    if (written <= 0) return;  // the host does not read: a serial line loses what is not read
    reply.erase(0, static_cast<std::size_t>(written));
  }
}

}  // namespace keypose::capture::shoot
