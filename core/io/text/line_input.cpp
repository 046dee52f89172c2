#include "core/io/text/line_input.h"

#include <poll.h>
#include <signal.h>
#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <utility>

namespace keypose {
namespace {

constexpr std::size_t kLongest = 64 << 10;
volatile sig_atomic_t interrupted = 0;

}  // namespace

void CatchInterrupts() {
  struct sigaction action = {};
  action.sa_handler = [](int) { interrupted = 1; };
  action.sa_flags = static_cast<int>(SA_RESETHAND);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaction(signal, &action, nullptr);
  ::signal(SIGPIPE, SIG_IGN);
}

bool WasInterrupted() { return interrupted != 0; }

std::optional<std::string> LineInput::Taken() {
  const std::size_t end = arrived_.find('\n');
  if (end == std::string::npos && !(ended_ && !arrived_.empty())) {
    if (arrived_.size() > kLongest) {
      arrived_.clear();
      drops_ = true;
    }
    return std::nullopt;
  }
  std::string line = arrived_.substr(0, end);
  arrived_.erase(0, end == std::string::npos ? end : end + 1);
  if (std::exchange(drops_, false)) return Taken();
  return line;
}

std::optional<std::string> LineInput::Next(double timeout_s) {
  if (auto line = Taken()) return line;
  const int timeout_ms = static_cast<int>(std::lround(1000 * timeout_s));
  if (ended_) {
    if (timeout_ms > 0) ::usleep(static_cast<useconds_t>(1000 * timeout_ms));
    return std::nullopt;
  }
  pollfd ready = {fd_, POLLIN, 0};
  if (::poll(&ready, 1, timeout_ms) <= 0) return std::nullopt;
  char bytes[4096];
  const ssize_t count = ::read(fd_, bytes, sizeof bytes);
  if (count > 0) arrived_.append(bytes, static_cast<std::size_t>(count));
  if (count == 0 || (count < 0 && errno != EINTR && errno != EAGAIN)) ended_ = true;
  return Taken();
}

}  // namespace keypose
