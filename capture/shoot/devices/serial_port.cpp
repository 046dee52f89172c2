#include "capture/shoot/devices/serial_port.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <vector>

#include "capture/shoot/devices/device_fault.h"

namespace keypose::capture::shoot {
namespace fs = std::filesystem;

namespace {

constexpr std::size_t kLongestLine = 256;

std::string AdviceFor(int error, const fs::path& device) {
  if (error == EACCES)
    return "type `sudo usermod -aG dialout $USER`, log out and in again, and start once more";
  if (error == EBUSY)
    return "end the other program that uses " + device.string() +
           " (a sender of G-code, a serial monitor)";
  return "plug in the turntable's cable, and give its name as --turntable; " + KnownPorts();
}

/// Raw bytes at 115,200 baud. Lines of the modem are left alone, so that closing resets no Arduino.
bool SetUp(int fd) {
  termios settings = {};
  if (tcgetattr(fd, &settings) != 0) return false;
  cfmakeraw(&settings);
  settings.c_cflag |= CLOCAL | CREAD;
  settings.c_cflag &= ~static_cast<tcflag_t>(HUPCL | CSTOPB | CRTSCTS);
  settings.c_cc[VMIN] = 0;
  settings.c_cc[VTIME] = 0;
  cfsetispeed(&settings, B115200);
  cfsetospeed(&settings, B115200);
  return tcsetattr(fd, TCSANOW, &settings) == 0;
}

}  // namespace

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

SerialPort::~SerialPort() { Close(); }

void SerialPort::Close() {
  if (fd_ >= 0) ::close(fd_);
  fd_ = -1;
  arrived_.clear();
}

void SerialPort::Open(const fs::path& device) {
  Close();
  device_ = device;
  fd_ = ::open(device.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  // Exclusive, so that a sender of G-code that is opened meanwhile does not talk in between.
  const bool fine = fd_ >= 0 && SetUp(fd_) && ioctl(fd_, TIOCEXCL) == 0;
  if (fine) return;
  const int reason = errno;
  Close();
  throw DeviceFault(
      "table-gone",
      "the turntable's port " + device.string() + " cannot be opened: " + std::strerror(reason),
      AdviceFor(reason, device), reason == EACCES);
}

void SerialPort::Gone() {
  Close();
  throw DeviceFault("table-gone", "the turntable's cable " + device_.string() + " is out",
                    "plug it in again; it goes on by itself", false);
}

void SerialPort::Write(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = fd_ < 0 ? -1 : ::write(fd_, bytes.data(), bytes.size());
    if (written > 0) {
      bytes.remove_prefix(static_cast<std::size_t>(written));
      continue;
    }
    if (fd_ < 0 || (errno != EAGAIN && errno != EINTR)) Gone();
    pollfd ready = {fd_, POLLOUT, 0};
    if (::poll(&ready, 1, 1000) == 0) Gone();
  }
}

std::optional<std::string> SerialPort::TakeLine() {
  const std::size_t end = arrived_.find('\n');
  if (end == std::string::npos) {
    if (arrived_.size() > kLongestLine) arrived_.clear();
    return std::nullopt;
  }
  std::string line = arrived_.substr(0, end);
  arrived_.erase(0, end + 1);
  std::erase_if(line, [](char c) { return c < ' ' || c > '~'; });
  return line.substr(0, kLongestLine);
}

std::optional<std::string> SerialPort::ReadLine(double timeout_s, Patience& patience) {
  const double until = patience.Now() + timeout_s;
  while (true) {
    if (auto line = TakeLine()) return line;
    if (fd_ < 0) Gone();
    pollfd ready = {fd_, POLLIN, 0};
    const int some = ::poll(&ready, 1, 20);
    if (some > 0) {
      char bytes[256];
      const ssize_t count = ::read(fd_, bytes, sizeof bytes);
      const bool nothing_yet = count < 0 && (errno == EAGAIN || errno == EINTR);
      if (count > 0) arrived_.append(bytes, static_cast<std::size_t>(count));
      if (count == 0 || (count < 0 && !nothing_yet)) Gone();
    }
    patience.Wait(0);
    if (arrived_.find('\n') == std::string::npos && patience.Now() >= until) return std::nullopt;
  }
}

void SerialPort::Drain() {
  arrived_.clear();
  if (fd_ >= 0) tcflush(fd_, TCIFLUSH);
}

}  // namespace keypose::capture::shoot
