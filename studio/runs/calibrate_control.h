// Starts `keypose armature calibrate` for the page, and relays what it asks and says.
#pragma once

#include <filesystem>
#include <string>

#include "studio/runs/session_relay.h"

namespace keypose::studio {

/// Files are named from the project's folder.
struct CalibrateSetup {
  /// - zero    sets the zero position
  /// - verify  how far each joint has drifted
  /// - wiggle  which sensors answer
  /// - gears   fits gear ratios to the angles that `known` has
  std::string what;
  std::string description, calibration;
  std::string port;            ///< a device, or "simulated"
  std::string known, written;  ///< of gears; `written`: a new description, or ""
};

class CalibrateControl {
 public:
  explicit CalibrateControl(std::filesystem::path project);
  /// Interrupts what is at work: an end is no Enter.
  ~CalibrateControl();

  /// @throws UsageError  there is no such `what` @throws LockedError  one is at work already
  void Start(const CalibrateSetup& setup);
  /// As Enter. @throws UsageError  none is at work
  void Go() { relay_.Say(""); }
  /// As Ctrl-C.
  void Interrupt() { relay_.Interrupt(); }
  /// Events: {event: "ask" or "said", words}, and what the controller tells of itself.
  SessionState State() const { return relay_.State(); }
  bool running() const { return relay_.running(); }

 private:
  const std::filesystem::path project_;
  SessionRelay relay_;
};

}  // namespace keypose::studio
