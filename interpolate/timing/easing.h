// Ease curves: from the share of a span's time to the share of its way.
#pragma once

#include "core/values/timeline.h"

namespace keypose::interpolation {

/// The share of the way at share `time` of the span's time, both 0..1; 0 and 1 are exact. As CSS's
/// cubic-bezier: the curve through (0,0), (x1,y1), (x2,y2), (1,1). y may leave [0,1] in between:
/// the motion then swings before the first key or beyond the second.
double EaseAt(const Ease& ease, double time);

/// dy/dx at the curve's first and last point; a vertical start counts as kSteepest.
double SlopeAtStart(const Ease& ease);
double SlopeAtEnd(const Ease& ease);
inline constexpr double kSteepest = 1e3;

}  // namespace keypose::interpolation
