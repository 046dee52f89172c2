#include "interpolate/timing/easing.h"

#include <algorithm>
#include <cmath>

namespace keypose::interpolation {

namespace {

/// Cubic Bezier with ends 0 and 1.
double Bezier(double a, double b, double u) {
  return ((1 - 3 * b + 3 * a) * u * u + (3 * b - 6 * a) * u + 3 * a) * u;
}

double Slope(double dx, double dy) {
  if (dx <= 0 && dy == 0) return 1;
  return std::clamp(dy / std::max(dx, 1e-300), -kSteepest, kSteepest);
}

}  // namespace

double EaseAt(const Ease& ease, double time) {
  if (time <= 0) return 0;
  if (time >= 1) return 1;
  if (ease.even()) return time;
  // x(u) does not decrease for control points in [0,1], so bisection always finds u, with the same
  // bits on every machine.
  double low = 0, high = 1;
  for (int k = 0; k < 60; ++k) {
    const double middle = 0.5 * (low + high);
    (Bezier(ease.x1, ease.x2, middle) < time ? low : high) = middle;
  }
  return Bezier(ease.y1, ease.y2, 0.5 * (low + high));
}

double SlopeAtStart(const Ease& ease) {
  if (ease.x1 > 0 || ease.y1 != 0) return Slope(ease.x1, ease.y1);
  return Slope(ease.x2,
               ease.y2);  // the first control point is at the end: the second gives the direction
}

double SlopeAtEnd(const Ease& ease) {
  return SlopeAtStart({1 - ease.x2, 1 - ease.y2, 1 - ease.x1, 1 - ease.y1});
}

}  // namespace keypose::interpolation
