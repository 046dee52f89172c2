#include "armature/matching/polyline.h"

#include <algorithm>
#include <limits>

#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose::armature {

using Eigen::Vector3d;

Polyline::Polyline(const PointsX3& points) : points_(points) {
  if (points.rows() < 2) throw InputError("armature: a chain's curve needs two points or more");
  if (!points.allFinite())
    throw InputError("armature: a chain's curve has a point that is not finite");
  along_.resize(points.rows() - 1, 3);
  ends_.push_back(0);
  for (Eigen::Index p = 0; p + 1 < points.rows(); ++p) {
    const Vector3d step = points.row(p + 1) - points.row(p);
    const double length = step.norm();
    along_.row(p) = length > 0 ? Vector3d(step / length) : Vector3d::Zero();
    ends_.push_back(ends_.back() + length);
  }
}

int Polyline::PieceAt(double at) const {
  const auto after = std::upper_bound(ends_.begin(), ends_.end(), at);
  const int piece = static_cast<int>(after - ends_.begin()) - 1;
  return std::clamp(piece, 0, SizeOf(ends_) - 2);
}

Vector3d Polyline::At(double at) const {
  const double inside = std::clamp(at, 0.0, length());
  const int piece = PieceAt(inside);
  return points_.row(piece) + (inside - ends_[piece]) * along_.row(piece);
}

Polyline::Foot Polyline::Nearest(const Vector3d& x, double from, double to) const {
  Foot nearest;
  nearest.squared_distance = std::numeric_limits<double>::infinity();
  for (int piece = PieceAt(std::max(from, 0.0)); piece + 1 < SizeOf(ends_); ++piece) {
    const double begin = std::max(from, ends_[piece]), end = std::min(to, ends_[piece + 1]);
    if (begin > end) break;
    const Vector3d start = points_.row(piece), along = along_.row(piece);
    const double free = ends_[piece] + (x - start).dot(along), at = std::clamp(free, begin, end);
    const Vector3d point = start + (at - ends_[piece]) * along;
    const double squared = (x - point).squaredNorm();
    if (squared >= nearest.squared_distance) continue;
    const bool slides = begin < free && free < end;
    nearest = {point, slides ? along : Vector3d::Zero(), at, squared};
  }
  return nearest;
}

}  // namespace keypose::armature
