#include "armature/matching/match_parts.h"

#include <cmath>

#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose::armature {

using Eigen::Vector3d;

void RequireLengths(const Eigen::VectorXd& lengths) {
  if (lengths.size() == 0) throw InputError("armature: a chain without a rod cannot be matched");
  for (Eigen::Index i = 0; i < lengths.size(); ++i)
    if (!(lengths[i] > 0) || !std::isfinite(lengths[i]))
      throw InputError("armature: rod " + std::to_string(i) + " of a chain has length " +
                       std::to_string(lengths[i]) + "; lengths must be positive");
}

ChainMatch Measured(const Polyline& curve, const Eigen::VectorXd& lengths,
                    const Directions& directions, const Vector3d& start) {
  ChainMatch match;
  const Eigen::Index rods = lengths.size();
  match.joints.resize(rods + 1, 3);
  match.directions.resize(rods, 3);
  match.joints.row(0) = start;
  for (Eigen::Index i = 0; i < rods; ++i) {
    match.directions.row(i) = directions[i];
    match.joints.row(i + 1) = match.joints.row(i) + lengths[i] * directions[i].transpose();
  }
  const PointsX3& ends = curve.points();
  match.near_gap = (match.joints.row(0) - ends.row(0)).norm();
  match.far_gap = (match.joints.row(rods) - ends.row(ends.rows() - 1)).norm();
  double sum = 0;
  for (Eigen::Index k = 1; k < rods; ++k)
    sum += std::sqrt(curve.Nearest(match.joints.row(k), 0, curve.length()).squared_distance);
  match.mean_distance = rods > 1 ? sum / static_cast<double>(rods - 1) : 0;
  return match;
}

Directions DirectionsOf(const PointsX3& rows) {
  Directions directions;
  for (Eigen::Index i = 0; i < rows.rows(); ++i) directions.push_back(rows.row(i));
  return directions;
}

Directions CurveDirections(const Polyline& curve, const Eigen::VectorXd& lengths) {
  const double share = curve.length() / lengths.sum();
  Directions directions;
  double at = 0;
  for (Eigen::Index i = 0; i < lengths.size(); ++i) {
    const Vector3d step = curve.At((at + lengths[i]) * share) - curve.At(at * share);
    at += lengths[i];
    const Vector3d before = directions.empty() ? Vector3d::UnitY() : directions.back();
    directions.push_back(step.norm() > 0 ? step.normalized() : before);
  }
  return directions;
}

std::vector<CurvePart> PartsOf(const Polyline& curve, const Eigen::VectorXd& lengths) {
  const double share = curve.length() / lengths.sum();
  std::vector<double> places = {0};
  for (Eigen::Index i = 0; i < lengths.size(); ++i)
    places.push_back(places.back() + lengths[i] * share);
  std::vector<CurvePart> parts;
  for (int k = 1; k + 1 < SizeOf(places); ++k)
    parts.push_back({0.5 * (places[k - 1] + places[k]), 0.5 * (places[k] + places[k + 1])});
  return parts;
}

}  // namespace keypose::armature
