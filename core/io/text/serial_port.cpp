#include "core/io/text/serial_port.h"

#include <fcntl.h>
#include <poll.h>
#include <stdlib.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <map>
#include <vector>

#include "core/values/errors.h"

namespace keypose {
namespace fs = std::filesystem;

namespace {

const std::map<int, speed_t>& Speeds() {
  static const std::map<int, speed_t> speeds = {
      {9600, B9600},     {19200, B19200},     {38400, B38400},    {57600, B57600},
      {115200, B115200}, {230400, B230400},   {460800, B460800},  {500000, B500000},
      {921600, B921600}, {1000000, B1000000}, {2000000, B2000000}};
  return speeds;
}

/// @param hung_up  whether DTR fell when the port was closed last: a port keeps its settings while
///                 nobody has it open, and this one is set in a new port
bool SetUp(int fd, speed_t speed, bool* hung_up) {
  termios settings = {};
  if (tcgetattr(fd, &settings) != 0) return false;
  *hung_up = (settings.c_cflag & HUPCL) != 0;
  cfmakeraw(&settings);
  settings.c_cflag |= CLOCAL | CREAD;
  settings.c_cflag &= ~static_cast<tcflag_t>(HUPCL | CSTOPB | CRTSCTS);
  settings.c_cc[VMIN] = 0;
  settings.c_cc[VTIME] = 0;
  cfsetispeed(&settings, speed);
  cfsetospeed(&settings, speed);
  return tcsetattr(fd, TCSANOW, &settings) == 0;
}

/// For this program alone. The terminal's own lock does not bind root, and the file's does.
bool Claim(int fd) {
  if (flock(fd, LOCK_EX | LOCK_NB) != 0) {
    if (errno == EWOULDBLOCK) errno = EBUSY;
    return false;
  }
  return ioctl(fd, TIOCEXCL) == 0;
}

int PollMilliseconds(double timeout_s) { return static_cast<int>(std::ceil(1000 * timeout_s)); }

bool IsNothingYet(ssize_t count) { return count < 0 && (errno == EAGAIN || errno == EINTR); }

}  // namespace

bool IsBaudRate(int baud) { return Speeds().contains(baud); }

std::string KnownPorts() {
  std::vector<std::string> names;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator("/dev/serial/by-id", ignored))
    names.push_back(entry.path().string());
  for (const auto& entry : fs::directory_iterator("/dev", ignored)) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with("ttyUSB") || name.starts_with("ttyACM"))
      names.push_back(entry.path().string());
  }
  if (names.empty()) return "there is no serial port on this machine at present";
  std::sort(names.begin(), names.end());
  std::string text = "there are:";
  for (const std::string& name : names) text += " " + name;
  return text;
}

void SerialPort::Close() {
  if (fd_ >= 0) ::close(fd_);
  fd_ = -1;
}

void SerialPort::Open(const fs::path& device, int baud) {
  Close();
  device_ = device;
  const auto speed = Speeds().find(baud);
  if (speed == Speeds().end())
    throw PortFault(
        "the port " + device.string() + " has no speed of " + std::to_string(baud) + " baud",
        EINVAL);
  fd_ = ::open(device.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (fd_ >= 0 && SetUp(fd_, speed->second, &has_raised_dtr_) && Claim(fd_)) return;
  const int reason = errno;
  Close();
  throw PortFault("the port " + device.string() + " cannot be opened: " + std::strerror(reason),
                  reason);
}

void SerialPort::Gone() {
  Close();
  throw PortFault("the cable of " + device_.string() + " is out", 0);
}

void SerialPort::Write(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = fd_ < 0 ? -1 : ::write(fd_, bytes.data(), bytes.size());
    if (written > 0) {
      bytes.remove_prefix(static_cast<std::size_t>(written));
      continue;
    }
    if (fd_ < 0 || (written < 0 && !IsNothingYet(written))) Gone();
    pollfd ready = {fd_, POLLOUT, 0};
    if (::poll(&ready, 1, 1000) == 0) Gone();
  }
}

std::string SerialPort::Read(double timeout_s) {
  if (fd_ < 0) Gone();
  pollfd ready = {fd_, POLLIN, 0};
  if (::poll(&ready, 1, PollMilliseconds(timeout_s)) <= 0) return "";
  char bytes[4096];
  const ssize_t count = ::read(fd_, bytes, sizeof bytes);
  if (count > 0) return std::string(bytes, static_cast<std::size_t>(count));
  if (!IsNothingYet(count)) Gone();
  return "";
}

void SerialPort::Drain() {
  if (fd_ >= 0) tcflush(fd_, TCIFLUSH);
}

void PseudoTerminal::Open(const fs::path& link) {
  Close();
  master_ = ::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC);
  char name[128];
  const bool fine = master_ >= 0 && ::grantpt(master_) == 0 && ::unlockpt(master_) == 0 &&
                    ::ptsname_r(master_, name, sizeof name) == 0;
  if (!fine)
    throw DiskError(std::string("no pseudo terminal for a simulated device: ") +
                    std::strerror(errno));
  // Else the terminal would send our own replies back to us before the host opens it.
  termios raw = {};
  tcgetattr(master_, &raw);
  cfmakeraw(&raw);
  tcsetattr(master_, TCSANOW, &raw);
  ::fcntl(master_, F_SETFL, O_NONBLOCK);
  const fs::path beside = link.string() + ".new";
  std::error_code error;
  fs::remove(beside, error);
  fs::create_symlink(name, beside, error);
  if (!error) fs::rename(beside, link, error);
  if (error) throw DiskError("cannot make " + link.string() + ": " + error.message());
}

void PseudoTerminal::Close() {
  if (master_ >= 0) ::close(master_);
  master_ = -1;
}

std::string PseudoTerminal::Read(double timeout_s) {
  pollfd ready = {master_, POLLIN, 0};
  const int milliseconds = PollMilliseconds(timeout_s);
  if (master_ < 0) {
    ::usleep(static_cast<useconds_t>(1000 * milliseconds));
    return "";
  }
  if (::poll(&ready, 1, milliseconds) > 0 && (ready.revents & POLLHUP))
    ::usleep(2000);  // nobody has opened the port
  char bytes[4096];
  const ssize_t count = ::read(master_, bytes, sizeof bytes);
  return count > 0 ? std::string(bytes, static_cast<std::size_t>(count)) : "";
}

void PseudoTerminal::Write(std::string_view bytes) {
  while (!bytes.empty() && master_ >= 0) {
    const ssize_t written = ::write(master_, bytes.data(), bytes.size());
    if (written <= 0) return;
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
}

}  // namespace keypose
