#include <cmath>

#include "armature/matching/chain_match.h"
#include "armature/matching/match_parts.h"

namespace keypose::armature {

using Eigen::Vector3d;

namespace {

/// The first length along the curve from `from` on where it is `radius` away from `center`.
/// @return  -1: nowhere
double FirstCrossing(const Polyline& curve, double from, const Vector3d& center, double radius) {
  const auto& ends = curve.ends();
  for (Eigen::Index p = 0; p + 1 < curve.points().rows(); ++p) {
    if (ends[p + 1] < from || ends[p + 1] == ends[p]) continue;
    const double begin = std::max(from, ends[p]);
    const Vector3d a = curve.At(begin) - center, b = curve.points().row(p + 1).transpose() - center;
    // A rod ends on the sphere's outside: the piece must leave it.
    if (a.norm() > radius || b.norm() < radius) continue;
    const Vector3d along = (b - a).normalized();
    const double middle = -a.dot(along);
    const double half_squared = radius * radius - (a.squaredNorm() - middle * middle);
    return begin + middle + std::sqrt(std::max(half_squared, 0.0));
  }
  // A rod that ends where the curve does may miss the end by rounding.
  const double end = (curve.At(curve.length()) - center).norm();
  return std::abs(end - radius) <= 1e-9 * radius ? curve.length() : -1;
}

}  // namespace

ChainMatch MatchGreedily(const Polyline& curve, const Eigen::VectorXd& lengths) {
  RequireLengths(lengths);
  Directions directions;
  Vector3d joint = curve.points().row(0);
  Vector3d last = (curve.At(std::min(lengths[0], curve.length())) - joint).normalized();
  if (!(last.norm() > 0)) last = Vector3d::UnitY();  // a curve that ends where it begins
  double at = 0;
  for (Eigen::Index i = 0; i < lengths.size(); ++i) {
    const double next = at < 0 ? -1 : FirstCrossing(curve, at, joint, lengths[i]);
    const Vector3d direction = next < 0 ? last : Vector3d((curve.At(next) - joint).normalized());
    at = next;
    directions.push_back(direction);
    joint += lengths[i] * direction;
    last = direction;
  }
  return Measured(curve, lengths, directions, curve.points().row(0));
}

}  // namespace keypose::armature
