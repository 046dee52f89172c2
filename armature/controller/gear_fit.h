// The true gear ratio of a joint from angles that are known otherwise: a square, a block, a stop.
#pragma once

#include <vector>

namespace keypose::armature {

struct KnownAngle {
  double value = 0;  ///< where the joint truly stood: [rad], or [m] of a slide
  double read = 0;   ///< where its encoder put it, with the description's gear
};

struct GearFit {
  double gear = 1;      ///< the true ratio over the description's
  double offset = 0;    ///< what is read where the joint is at zero, unit of the values
  double residual = 0;  ///< root mean square of what is left, unit of the values
};

/// read = gear * value + offset, by least squares.
/// @throws InputError  fewer than two values that differ; a ratio that is off by more than half, or
/// of the other sign: the description's scale is wrong
GearFit FitGear(const std::vector<KnownAngle>& known);

}  // namespace keypose::armature
