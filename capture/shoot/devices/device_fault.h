// What can go wrong with a camera or a turntable, in words for the person beside it.
#pragma once

#include <stdexcept>
#include <string>

namespace keypose::capture::shoot {

/// A fault that does not end the session: it is told, and the device is tried again.
struct DeviceFault : std::runtime_error {
  /// @param fault_code  as in docs/shoot.md, such as "camera-grabbed"
  /// @param said        what happened, a sentence
  /// @param advice      what the person can do, a sentence
  /// @param hand        it cannot be over before the person has done something and says so
  DeviceFault(std::string fault_code, const std::string& said, std::string advice, bool hand)
      : std::runtime_error(said),
        code(std::move(fault_code)),
        what_to_do(std::move(advice)),
        needs_hand(hand) {}
  std::string code, what_to_do;
  bool needs_hand = false;
};

/// The table stands at an unknown angle: it lost power or was reset while it turned.
struct PositionLost : DeviceFault {
  using DeviceFault::DeviceFault;
};

}  // namespace keypose::capture::shoot
