// An armature on a serial port: its joints' values, whatever happens to cable, box and sensors.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "armature/controller/box_link.h"
#include "armature/controller/calibration.h"
#include "armature/controller/joint_tracker.h"
#include "armature/description/armature.h"

namespace keypose::armature {

struct Reading {
  double time_s = 0;           ///< since some moment; never runs backwards
  bool fresh = false;          ///< the controller answered; else these are the last known values
  std::vector<double> values;  ///< as ForwardKinematics takes them
  std::vector<int> held;       ///< joints whose counter jumped: their values are the last good ones
  std::vector<int> changed;    ///< joints whose value is another one than at the reading before
};

/// Something that a person should hear of.
struct ReaderEvent {
  /// "cable-out", "cable-back", "silent", "power-lost", "sensor-jumped", "sensor-back",
  /// "sensor-lost-count", "sensor-no-signal"
  std::string code;
  std::string words, what_to_do;  ///< a sentence each; the second may be empty
  int joint = -1;                 ///< that it is about
};

struct PortOptions {
  std::string device;    ///< such as /dev/ttyACM0
  int baud = 1000000;    ///< as core/io/text/serial_port.h takes it
  double retry_s = 0.3;  ///< between attempts to reach a controller that is away
  /// A board that begins again when its port is opened is not spoken to for so long [s]: its boot
  /// loader would take what it hears for a new program.
  double start_s = 2.5;
  LinkOptions link;
};

class ArmatureReader {
 public:
  /// Opens the port and reads once.
  /// @param armature  must outlive this
  /// @throws ToolError   no such port, no right to open it, another program holds it, or nothing on
  /// it speaks the protocol; says what to do
  /// @throws InputError  the armature has sensors that the controller does not
  ArmatureReader(const Armature& armature, const PortOptions& port, const Calibration& calibration);
  ~ArmatureReader();

  /// Reads once; tries to reach the controller again when it was away.
  /// @throws InputError  a controller came back with fewer sensors
  const Reading& Poll();
  const Reading& last() const { return reading_; }
  /// Events since the last call, oldest first.
  std::vector<ReaderEvent> TakeEvents();
  /// As it stands now, to be kept.
  Calibration calibration() const;
  const BoxInfo& box() const;
  /// For calibration: the joint stands at this value now.
  void SetValue(std::size_t joint, double value);
  void SetGear(std::size_t joint, double gear);
  const JointTracker& tracker() const { return tracker_; }
  /// The controller's own counters to 0, with all joints at 0.
  /// @throws ToolError  it does not answer
  void ResetCounters();
  /// Requests that were repeated, and replies that were damaged, so far.
  int repeats() const;
  int damaged() const;

 private:
  class Port;
  bool Connect();
  void Begin();
  void ForgetLostPower();
  bool HasLostCount(int joint) const;
  void EndLostCount(std::size_t joint);
  void Lose(const std::string& code, const std::string& words, const std::string& what_to_do);
  void TellHeld();
  void TellFlags();
  void Say(const std::string& code, const std::string& words, const std::string& what_to_do,
           int joint = -1);

  const Armature& armature_;
  PortOptions options_;
  std::unique_ptr<Port> port_;
  std::unique_ptr<BoxLink> link_;
  JointTracker tracker_;
  int boot_;
  bool away_ = true, opened_ = false, was_silent_ = false;
  double next_try_s_ = 0, next_flags_s_ = 0, greet_s_ = 0;
  Reading reading_;
  std::vector<int> told_held_;
  std::vector<unsigned> told_flags_;
  std::vector<ReaderEvent> events_;
  int repeats_ = 0, damaged_ = 0;  ///< of links that were given up
};

}  // namespace keypose::armature
