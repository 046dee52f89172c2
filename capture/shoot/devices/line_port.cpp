#include "capture/shoot/devices/line_port.h"

#include <algorithm>
#include <cerrno>

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

[[noreturn]] void Gone(const fs::path& device) {
  throw DeviceFault("table-gone", "the turntable's cable " + device.string() + " is out",
                    "plug it in again; it goes on by itself", false);
}

}  // namespace

void LinePort::Close() {
  port_.Close();
  arrived_.clear();
}

void LinePort::Open(const fs::path& device) {
  arrived_.clear();
  try {
    port_.Open(device, 115200);
  } catch (const PortFault& fault) {
    throw DeviceFault("table-gone", std::string("the turntable: ") + fault.what(),
                      AdviceFor(fault.error, device), fault.error == EACCES);
  }
}

void LinePort::Write(std::string_view bytes) {
  try {
    port_.Write(bytes);
  } catch (const PortFault&) {
    Close();
    Gone(port_.device());
  }
}

std::optional<std::string> LinePort::TakeLine() {
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

std::optional<std::string> LinePort::ReadLine(double timeout_s, Patience& patience) {
  const double until = patience.Now() + timeout_s;
  while (true) {
    if (auto line = TakeLine()) return line;
    try {
      arrived_ += port_.Read(0.02);
    } catch (const PortFault&) {
      Close();
      Gone(port_.device());
    }
    patience.Wait(0);
    if (arrived_.find('\n') == std::string::npos && patience.Now() >= until) return std::nullopt;
  }
}

void LinePort::Drain() {
  arrived_.clear();
  port_.Drain();
}

}  // namespace keypose::capture::shoot
