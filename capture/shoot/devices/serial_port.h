// A serial port, or a pseudo terminal in its place, by POSIX termios.
//
// Not libserialport: it opens no pseudo terminals (sigrokproject/libserialport, pull request 4),
// and the simulated turntables of the tests must run the code that the real ones run.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "capture/shoot/devices/patience.h"

namespace keypose::capture::shoot {

/// Lines of text to and from a device: 115,200 baud, 8 bits, no parity, no flow control.
class SerialPort {
 public:
  SerialPort() = default;
  ~SerialPort();
  SerialPort(const SerialPort&) = delete;
  SerialPort& operator=(const SerialPort&) = delete;

  /// @throws DeviceFault  "table-gone": no such device, no right to open it, or another program
  /// holds it; says what to do, and which ports there are
  void Open(const std::filesystem::path& device);
  void Close();
  bool is_open() const { return fd_ >= 0; }

  /// @throws DeviceFault  "table-gone"
  void Write(std::string_view bytes);
  /// The next line without its end; nothing when none was complete in time. Bytes that are not
  /// printable ASCII are dropped, and lines cut off at 256 bytes.
  /// @throws DeviceFault  "table-gone"
  std::optional<std::string> ReadLine(double timeout_s, Patience& patience);
  /// Forgets what has arrived.
  void Drain();

 private:
  [[noreturn]] void Gone();
  std::optional<std::string> TakeLine();
  std::filesystem::path device_;
  int fd_ = -1;
  std::string arrived_;
};

/// The serial ports of this machine, by names that stay the same where there are such.
std::string KnownPorts();

}  // namespace keypose::capture::shoot
