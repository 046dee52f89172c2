// Starts `keypose shoot`, relays its events, and passes commands on (docs/shoot.md, --commands).
// The session is in the project's files: whoever starts it again goes on where it was.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "studio/runs/session_relay.h"

namespace keypose::studio {

/// As the flags of `keypose shoot` say.
struct ShootSetup {
  std::string pose, camera, turntable;
  std::vector<double> rings_deg;
  int angles = 24;
  int flips = 0;
  /// Further flags by their names: settle, focus-stack, white-balance, axis, degrees-per-unit,
  /// speed.
  std::vector<std::pair<std::string, std::string>> more = {};
};

class ShootControl {
 public:
  ShootControl(std::filesystem::path project, SessionListener listener);

  /// @throws LockedError  a session is at work already @throws DiskError
  void Start(const ShootSetup& setup);
  /// @param command  one JSON object in one line @throws UsageError  no session listens
  void Say(const std::string& command) { relay_.Say(command); }
  /// As Ctrl-C: also a camera that does not answer is left.
  void Interrupt() { relay_.Interrupt(); }
  SessionState State() const { return relay_.State(); }
  /// The newest picture of the live view; it may not be there.
  std::filesystem::path LiveFile() const { return File("live.jpg"); }

 private:
  std::filesystem::path File(const char* name) const;

  const std::filesystem::path project_;
  SessionRelay relay_;
};

}  // namespace keypose::studio
