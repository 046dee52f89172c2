#include "synth/worlds/flesh.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/values/angles.h"

namespace keypose::synth {
namespace {

using Eigen::Vector3d;

double FleshMin(double a, double b, double width) {
  const double h = std::max(width - std::abs(a - b), 0.0) / width;
  return std::min(a, b) - h * h * width / 4;
}

constexpr double kFleshFillet = 0.03;  // [m]

// x right, y up, z to the viewer becomes z up.
Rigid3 Upright(const Rigid3& frame) {
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(kPi / 2, Vector3d::UnitX()));
  return {(turn * frame.rotation).normalized(), turn * frame.translation};
}

}  // namespace

double FleshDistance(const Flesh& lump, const Vector3d& x) {
  const Vector3d axis = lump.b - lump.a;
  const double length2 = axis.squaredNorm();
  const double h = length2 > 0 ? std::clamp((x - lump.a).dot(axis) / length2, 0.0, 1.0) : 0.0;
  return (x - lump.a - h * axis).norm() - (lump.ra + h * (lump.rb - lump.ra));
}

double BodyDistance(const std::vector<Flesh>& lumps, const Vector3d& x) {
  double distance = std::numeric_limits<double>::infinity();
  for (const Flesh& lump : lumps) {
    const double d = FleshDistance(lump, x);
    distance = std::isinf(distance) ? d : FleshMin(distance, d, kFleshFillet);
  }
  return distance;
}

std::vector<Rigid3> UprightFrames(const MotionClip& clip, int frame) {
  std::vector<Rigid3> frames = JointFrames(clip, frame);
  for (Rigid3& f : frames) f = Upright(f);
  return frames;
}

}  // namespace keypose::synth
