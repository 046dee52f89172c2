// A turntable's controller behind a pseudo terminal: a thread that reads lines, turns, and fails.
#pragma once

#include <atomic>
#include <filesystem>
#include <memory>
#include <string>
#include <thread>

#include "capture/shoot/simulation/fault_plan.h"
#include "capture/shoot/simulation/simulated_world.h"
#include "core/io/text/serial_port.h"

namespace keypose::capture::shoot {

/// The motor below both protocols. Positions are degrees as the controller counts them.
struct SimulatedMotor {
  double counted_deg = 0;  ///< 0 after a reset, whatever the table's true angle
  double target_deg = 0;
  bool stalled = false;  ///< it says that it turns, and does not
  bool moving() const { return counted_deg != target_deg || stalled; }
};

/// One protocol.
class Protocol {
 public:
  virtual ~Protocol() = default;
  /// Power-up: forgets everything. @return what is sent then
  virtual std::string Reset(int boot) = 0;
  /// Bytes from the host. @return what is sent in reply
  virtual std::string Receive(const std::string& bytes, SimulatedMotor& motor) = 0;
  /// Moves that were started since power-up of the simulation, counted over resets.
  int moves = 0;
};

/// Habits of real controllers.
struct GrblHabits {
  bool inches = false;         ///< tells places in inches ($13=1)
  bool lists_settings = true;  ///< answers $$
  int early_idle = 0;          ///< reports after a move that say Idle, at the target already
  bool two_oks = false;        ///< every line is acknowledged twice
  int limit_at_move = 0;  ///< this move ends in ALARM:1, after which only Ctrl-X is heard; 0: none
};
std::unique_ptr<Protocol> MakeGrblFirmware(const GrblHabits& habits = {});
/// @param steps_a_turn  of the motor
std::unique_ptr<Protocol> MakeStepsFirmware(int steps_a_turn);

struct FirmwareOptions {
  double speed_deg_s = 720;
  double unplugged_s = 0.3;  ///< until a pulled cable is back
  int boot = 1;              ///< number of its first power-up; one more after each reset
};

/// Runs until destroyed. The port is a link in the file system, as those of /dev/serial/by-id,
/// since a cable that comes back may have another device.
class Firmware {
 public:
  /// All must outlive this.
  /// @param link  the port's name; an old one is replaced
  /// @throws DiskError  no pseudo terminal
  Firmware(std::unique_ptr<Protocol> protocol, SimulatedWorld& world, FaultPlan& faults,
           const std::filesystem::path& link, const FirmwareOptions& options = {});
  ~Firmware();
  Firmware(const Firmware&) = delete;
  Firmware& operator=(const Firmware&) = delete;

 private:
  void Run();
  void Serve(double passed_s, const std::string& received);
  void MakeFaults();
  void Turn(double passed_s);
  void Send(std::string reply);

  std::unique_ptr<Protocol> protocol_;
  SimulatedWorld& world_;
  FaultPlan& faults_;
  std::filesystem::path link_;
  FirmwareOptions options_;
  SimulatedMotor motor_;
  PseudoTerminal terminal_;
  int boot_ = 1, known_moves_ = 0;
  int lose_replies_ = 0, lose_lines_ = 0;
  double back_in_s_ = 0, mute_s_ = 0;
  bool unplug_in_mid_turn_ = false, reset_in_mid_turn_ = false;
  std::atomic<bool> ends_{false};
  std::thread thread_;
};

}  // namespace keypose::capture::shoot
