// A turntable that turns by itself.
#pragma once

#include <string>

#include "capture/shoot/devices/patience.h"

namespace keypose::capture::shoot {

/// Angles are in degrees; those that differ by whole turns are the same place.
class TurntableDevice {
 public:
  virtual ~TurntableDevice() = default;

  /// Opens the device, or opens it again after a fault.
  /// @param angle_deg  where the table stands, as known from before
  /// @param turning    the table was on its way when it was last heard of
  /// @param memory     what Memory() gave before that turn; "" if nothing is known
  /// @throws DeviceFault   it cannot be opened, or does not answer
  /// @throws PositionLost  it was reset on its way
  virtual void Connect(double angle_deg, bool turning, const std::string& memory,
                       Patience& patience) = 0;
  /// Turns the shorter way (forwards for half a turn), and returns when the table stands there.
  /// May be called again after a fault and Connect.
  /// @throws DeviceFault, PositionLost
  virtual void TurnTo(double angle_deg, Patience& patience) = 0;
  /// The table was set to this angle by hand.
  virtual void Declare(double angle_deg, Patience& patience) = 0;
  /// Where it stands; after an interrupted turn, where it stood before.
  virtual double angle_deg() const = 0;
  /// What tells, together with the angle, whether the table has lost its position since.
  virtual std::string Memory() const { return ""; }
};

/// The place nearest to `from_deg` that is `to_deg` plus whole turns; forwards for half a turn.
double NearestTurn(double from_deg, double to_deg);
/// In [0, 360).
double WithinTurn(double angle_deg);

}  // namespace keypose::capture::shoot
