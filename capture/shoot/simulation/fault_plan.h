// Faults that a simulated camera or turntable makes, once each, at a given moment.
#pragma once

#include <mutex>
#include <string>
#include <vector>

namespace keypose::capture::shoot {

/// "lost-reply@5": at the fifth move of the table, or the fifth release of the camera.
struct PlannedFault {
  std::string kind;
  int at = 1;  ///< from 1
};

/// Of the turntable: lost-reply, lost-line, garbage, stall, unplug, reset, mute. Of the camera:
/// battery, half-file, card-full, blurred, grabbed, camera-unplugged.
extern const std::vector<std::string> kFaultKinds;

/// "lost-reply@5,stall@9".
/// @throws UsageError  an unknown kind, or no number
std::vector<PlannedFault> ParseFaults(const std::string& text);

/// Thread-safe.
class FaultPlan {
 public:
  FaultPlan() = default;
  explicit FaultPlan(std::vector<PlannedFault> faults) : faults_(std::move(faults)) {}
  /// Whether the fault is due at this count; true once for each planned one.
  bool Due(const std::string& kind, int count);

 private:
  std::mutex mutex_;
  std::vector<PlannedFault> faults_;
};

}  // namespace keypose::capture::shoot
