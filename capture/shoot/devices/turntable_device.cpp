#include "capture/shoot/devices/turntable_device.h"

#include <cmath>

namespace keypose::capture::shoot {

double WithinTurn(double angle_deg) {
  const double within = std::fmod(angle_deg, 360.0);
  const double positive = within < 0 ? within + 360 : within;
  return positive >= 360 ? 0 : positive;  // a tiny negative angle rounds to 360
}

double NearestTurn(double from_deg, double to_deg) {
  double way = WithinTurn(to_deg - from_deg);
  if (way > 180) way -= 360;
  return from_deg + way;
}

}  // namespace keypose::capture::shoot
