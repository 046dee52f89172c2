// Serial ports, and pseudo terminals in their place, by POSIX termios
// (docs/decisions/serial-port-by-termios.md).
#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>
#include <string_view>

namespace keypose {

/// A port that cannot be opened, or whose cable is out.
struct PortFault : std::runtime_error {
  PortFault(const std::string& said, int reason) : std::runtime_error(said), error(reason) {}
  int error;  ///< errno; EBUSY: another program holds it; EACCES: no right to open it; 0: gone
};

/// Raw bytes to and from a device: 8 bits, no parity, no flow control. Lines of the modem are left
/// alone, so that closing resets no Arduino.
class SerialPort {
 public:
  SerialPort() = default;
  ~SerialPort() { Close(); }
  SerialPort(const SerialPort&) = delete;
  SerialPort& operator=(const SerialPort&) = delete;

  /// Opens it for this program alone.
  /// @param baud  9600, 19200, 38400, 57600, 115200, 230400, 460800, 500000, 921600, 1000000 or
  ///              2000000
  /// @throws PortFault
  void Open(const std::filesystem::path& device, int baud);
  void Close();
  bool is_open() const { return fd_ >= 0; }
  /// Opening it has raised DTR, by which an Arduino begins again: the port was new, or whoever had
  /// it last let DTR fall.
  bool has_raised_dtr() const { return has_raised_dtr_; }
  const std::filesystem::path& device() const { return device_; }

  /// @throws PortFault  the cable is out, or the device takes nothing for a second
  void Write(std::string_view bytes);
  /// What has arrived; waits for the first byte, and gives "" if none came in time.
  /// @throws PortFault  the cable is out
  std::string Read(double timeout_s);
  /// Forgets what has arrived.
  void Drain();

 private:
  [[noreturn]] void Gone();
  std::filesystem::path device_;
  int fd_ = -1;
  bool has_raised_dtr_ = false;
};

/// Whether SerialPort::Open takes this speed.
bool IsBaudRate(int baud);
/// The serial ports of this machine, by names that stay the same where there are such: a clause for
/// a message.
std::string KnownPorts();

/// The device's side of a serial line: a pseudo terminal, for simulated devices. Its name is a
/// link, as in /dev/serial/by-id, since a cable that comes back may have another device.
class PseudoTerminal {
 public:
  PseudoTerminal() = default;
  ~PseudoTerminal() { Close(); }
  PseudoTerminal(const PseudoTerminal&) = delete;
  PseudoTerminal& operator=(const PseudoTerminal&) = delete;

  /// @param link  its name; an old link is replaced
  /// @throws DiskError  no pseudo terminal, or the link cannot be made
  void Open(const std::filesystem::path& link);
  /// To the host the cable is out then. The link stays.
  void Close();
  bool is_open() const { return master_ >= 0; }
  /// Bytes from the host, waiting at most so long for them.
  std::string Read(double timeout_s);
  /// Bytes that the host does not read in time are lost, as on a serial line.
  void Write(std::string_view bytes);

 private:
  int master_ = -1;
};

}  // namespace keypose
