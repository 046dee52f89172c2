#include "synth/worlds/pose.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/values/angles.h"
#include "core/values/errors.h"

namespace keypose::synth {
namespace {

// C2 step from 0 to 1.
double SmoothStep(double t) {
  t = std::clamp(t, 0.0, 1.0);
  return t * t * t * (t * (t * 6 - 15) + 10);
}

double DistanceTo(const std::vector<Eigen::Vector3d>& path, const Eigen::Vector3d& x) {
  double nearest = (x - path.front()).norm();
  for (std::size_t i = 1; i < path.size(); ++i) {
    const Eigen::Vector3d along = path[i] - path[i - 1];
    const double share = std::clamp((x - path[i - 1]).dot(along) / along.squaredNorm(), 0.0, 1.0);
    nearest = std::min(nearest, (x - path[i - 1] - share * along).norm());
  }
  return nearest;
}

// Barr's bend along `axis`: constant curvature from begin to end, straight on both sides.
// Coordinates: s along the axis, y along `side`; the third does not change.
Eigen::Vector3d Bend(const Deformation& d, const Eigen::Vector3d& x, double angle) {
  if (angle == 0) return x;
  const Eigen::Vector3d side = d.hinge.cross(d.axis);  // the limb bends towards this
  const Eigen::Vector3d local = x - d.origin;
  const double s = local.dot(d.axis), y = local.dot(side);
  if (s <= d.begin) return x;
  const double length = d.end - d.begin, curvature = angle / length;
  const double turned = curvature * std::min(s - d.begin, length);
  const double beyond = std::max(0.0, s - d.end);
  const double c = std::cos(turned), sn = std::sin(turned);
  // sin(a)/k and (1-cos(a))/k are the arc's end point; the series is exact for small curvatures.
  const double arc = std::min(s - d.begin, length);
  const double along = std::abs(turned) < 1e-6 ? arc : sn / curvature,
               across = std::abs(turned) < 1e-6 ? arc * turned / 2 : (1 - c) / curvature;
  const double new_s = d.begin + along - sn * y + c * beyond, new_y = across + c * y + sn * beyond;
  return x + (new_s - s) * d.axis + (new_y - y) * side;
}

Eigen::Vector3d Twist(const Deformation& d, const Eigen::Vector3d& x, double whole_angle) {
  const double s = (x - d.origin).dot(d.axis);
  const double angle = whole_angle * SmoothStep((s - d.begin) / (d.end - d.begin));
  return d.origin + Eigen::AngleAxisd(angle, d.axis) * (x - d.origin);
}

Eigen::Vector3d Squash(const Deformation& d, const Eigen::Vector3d& x, double weight) {
  const double ratio = 1 + weight * (d.ratio - 1);
  const Eigen::Vector3d local = x - d.origin;
  const Eigen::Vector3d along = local.dot(d.axis) * d.axis;
  return d.origin + ratio * along + (local - along) / std::sqrt(ratio);
}

}  // namespace

double Deformation::Weight(const Eigen::Vector3d& rest) const {
  const double off = spine.empty() ? (rest - center).norm() : DistanceTo(spine, rest);
  const double in_ball = radius <= 0 ? 1 : 1 - SmoothStep((off - radius) / falloff);
  if (reach <= 0) return in_ball;
  return in_ball * (1 - SmoothStep(((rest - origin).cross(axis).norm() - reach) / falloff));
}

Eigen::Vector3d Deformation::Apply(const Eigen::Vector3d& x, const Eigen::Vector3d& rest) const {
  const double weight = Weight(rest);
  if (weight == 0) return x;
  switch (kind) {
    case Kind::kBend:
      return Bend(*this, x, angle * weight);
    case Kind::kTwist:
      return Twist(*this, x, angle * weight);
    case Kind::kSquash:
      return Squash(*this, x, weight);
  }
  return x;
}

Deformation LimbBend(const Eigen::Vector3d& origin, const Eigen::Vector3d& axis,
                     const Eigen::Vector3d& towards, double begin, double end, double degrees,
                     const Eigen::Vector3d& center, double radius) {
  Deformation bend;
  bend.kind = Deformation::Kind::kBend;
  bend.origin = origin;
  bend.axis = axis.normalized();
  bend.hinge = bend.axis.cross(towards).normalized();
  bend.begin = begin;
  bend.end = end;
  bend.angle = degrees * kPi / 180;
  bend.center = center;
  bend.radius = radius;
  bend.falloff = 0.008;
  return bend;
}

Deformation TrunkTwist(double begin, double end, double degrees) {
  Deformation twist;
  twist.kind = Deformation::Kind::kTwist;
  twist.origin = Eigen::Vector3d(0.001, -0.001, 0);
  twist.begin = begin;
  twist.end = end;
  twist.angle = degrees * kPi / 180;
  return twist;
}

Deformation WholeSquash(double ratio) {
  Deformation squash;
  squash.kind = Deformation::Kind::kSquash;
  squash.ratio = ratio;
  return squash;
}

Eigen::Vector3d Pose::operator()(const Eigen::Vector3d& rest) const {
  Eigen::Vector3d x = rest;
  for (const Deformation& step : steps) x = step.Apply(x, rest);
  return x;
}

PointsX3 Pose::operator()(const PointsX3& rest) const {
  PointsX3 posed(rest.rows(), 3);
  for (Eigen::Index i = 0; i < rest.rows(); ++i)
    posed.row(i) = (*this)(Eigen::Vector3d(rest.row(i))).transpose();
  return posed;
}

Eigen::Matrix3d Pose::Jacobian(const Eigen::Vector3d& rest, double h) const {
  Eigen::Matrix3d jacobian;
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector3d step = h * Eigen::Vector3d::Unit(k);
    jacobian.col(k) =
        ((*this)(Eigen::Vector3d(rest + step)) - (*this)(Eigen::Vector3d(rest - step))) / (2 * h);
  }
  return jacobian;
}

Eigen::Vector3d Pose::Inverse(const Eigen::Vector3d& posed, const Eigen::Vector3d& guess) const {
  Eigen::Vector3d rest = guess;
  double error = ((*this)(rest)-posed).norm();
  for (int round = 0; round < 60 && error > 1e-12; ++round) {
    const Eigen::Vector3d step = Jacobian(rest).partialPivLu().solve(posed - (*this)(rest));
    // Halve the step until the error falls: distant guesses overshoot where a limb bends.
    double share = 1, next = 0;
    for (; share > 1e-4; share /= 2) {
      next = ((*this)(Eigen::Vector3d(rest + share * step)) - posed).norm();
      if (next < error) break;
    }
    if (!(next < error)) break;
    rest += share * step;
    error = next;
  }
  if (!(error < 1e-9))
    throw SolverError("synth: the pose '" + name +
                      "' cannot be inverted at this point; start from a closer guess");
  return rest;
}

}  // namespace keypose::synth
