// Lines of text to and from a device on a serial port (core/io/text/serial_port.h).
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "capture/shoot/devices/patience.h"
#include "core/io/text/serial_port.h"

namespace keypose::capture::shoot {

/// A turntable's port: 115,200 baud, 8 bits, no parity, no flow control.
class LinePort {
 public:
  /// @throws DeviceFault  "table-gone": no such device, no right to open it, or another program
  /// holds it; says what to do, and which ports there are
  void Open(const std::filesystem::path& device);
  void Close();
  bool is_open() const { return port_.is_open(); }

  /// @throws DeviceFault  "table-gone"
  void Write(std::string_view bytes);
  /// The next line without its end; nothing when none was complete in time. Bytes that are not
  /// printable ASCII are dropped, and lines cut off at 256 bytes.
  /// @throws DeviceFault  "table-gone"
  std::optional<std::string> ReadLine(double timeout_s, Patience& patience);
  /// Forgets what has arrived.
  void Drain();

 private:
  std::optional<std::string> TakeLine();
  SerialPort port_;
  std::string arrived_;
};

}  // namespace keypose::capture::shoot
