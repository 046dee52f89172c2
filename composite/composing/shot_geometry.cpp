#include "composite/composing/shot_geometry.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose::composite {
namespace {

/// A reconstructed pose stands on z = 0. Where its lowest vertex is this near (of its height), that
/// is the table, and not what cleaning has left or taken of its soles.
constexpr double kStandsOnZero = 0.05;

/// Time counts in frames of the animation, as the camera moved on by the film's own clock.
std::vector<CameraKnot> KnotsOf(const FilmedShot& shot, const FilmPlan& plan,
                                const std::vector<Anchor>& anchors) {
  if (anchors.size() < 2)
    throw InputError(
        "composite: the camera of this shot moves, but only one of its frames was located; locate "
        "two or more, best all that were filmed");
  std::vector<CameraKnot> knots;
  for (const Anchor& anchor : anchors)
    knots.push_back({1.0 * anchor.animation, shot.frames[anchor.shot_frame].camera_from_world});
  for (const CameraBetween& camera : shot.between)
    knots.push_back({(camera.frame - plan.first_frame) * plan.per_frame, camera.camera_from_world});
  std::sort(knots.begin(), knots.end(),
            [](const CameraKnot& a, const CameraKnot& b) { return a.time < b.time; });
  return knots;
}

}  // namespace

ShotGeometry::ShotGeometry(const FilmedShot& shot, const FilmPlan& plan,
                           const std::vector<Mesh>& frames, const AnimationTimes& times)
    : shot_(shot), frames_(frames), t_(times.t) {
  if (SizeOf(t_) != SizeOf(frames)) {
    t_.resize(frames.size());
    for (std::size_t i = 0; i < t_.size(); ++i) t_[i] = static_cast<double>(i);
  }
  for (int i = 0; i < SizeOf(shot.frames); ++i) {
    const int shown = (shot.frames[i].frame - plan.first_frame) * plan.per_frame;
    if (shown >= 0 && shown < SizeOf(frames)) anchors_.push_back({shown, i});
  }
  if (anchors_.empty())
    throw InputError("composite: no located frame of the shot lies within the animation");
  if (!shot.still) path_.emplace(KnotsOf(shot, plan, anchors_));
  for (std::size_t i = 0; i + 1 < anchors_.size(); ++i)
    ways_.emplace_back(PointsOfFrame(anchors_[i].animation),
                       PointsOfFrame(anchors_[i + 1].animation));
}

const Similarity3& ShotGeometry::PlaceOf(const Anchor& anchor) const {
  return shot_.frames[anchor.shot_frame].world_from_character;
}

View ShotGeometry::ViewAt(double frame) const {
  return {"shot", shot_.camera, path_ ? path_->At(frame) : shot_.frames[0].camera_from_world};
}

ShotGeometry::Between ShotGeometry::At(double frame) const {
  const auto after = std::find_if(anchors_.begin(), anchors_.end(),
                                  [&](const Anchor& a) { return a.animation >= frame; });
  const int i = static_cast<int>(after - anchors_.begin());
  if (i == 0) return {0, 0, 0};
  if (i == SizeOf(anchors_)) return {i - 1, i - 1, 0};
  return {i - 1, i, ShareOfWay(anchors_[i - 1].animation, anchors_[i].animation, frame)};
}

double ShotGeometry::ShareOfWay(int from, int to, double frame) const {
  const auto time = [&](double at) {
    const int low = std::clamp(static_cast<int>(at), 0, SizeOf(t_) - 1),
              high = std::min(low + 1, SizeOf(t_) - 1);
    return t_[low] + (at - low) * (t_[high] - t_[low]);
  };
  const double way = time(to) - time(from);
  return way > 0 ? std::clamp((time(frame) - time(from)) / way, 0.0, 1.0) : 0.5;
}

PointsX3 ShotGeometry::ShiftsOfFrame(int frame) const {
  const auto after = shifts_.lower_bound(frame);
  if (after == shifts_.end()) return std::prev(after)->second;
  if (after == shifts_.begin() || after->first == frame) return after->second;
  const auto before = std::prev(after);
  const double share = ShareOfWay(before->first, after->first, frame);
  return (1 - share) * before->second + share * after->second;
}

PointsX3 ShotGeometry::PointsOfFrame(int frame) const {
  const Between at = At(frame);
  const Anchor &before = anchors_[at.before], &after = anchors_[at.after];
  const PointsX3& shape = frames_[frame].points;
  if (before.animation == frame || at.before == at.after)
    return Transformed(PlaceOf(before), shape);
  if (after.animation == frame) return Transformed(PlaceOf(after), shape);
  const double scale =
      std::pow(PlaceOf(before).scale, 1 - at.share) * std::pow(PlaceOf(after).scale, at.share);
  return ways_[at.before].Place(shape, scale, at.share);
}

PointsX3 ShotGeometry::Points(double frame) const {
  const double at = std::clamp(frame, 0.0, SizeOf(frames_) - 1.0);
  const int low = static_cast<int>(at);
  const double share = at - low;
  const auto points = [&](int f) -> PointsX3 {
    if (shifts_.empty()) return PointsOfFrame(f);
    return PointsOfFrame(f) + ShiftsOfFrame(f);
  };
  if (share < 1e-9) return points(low);
  return (1 - share) * points(low) + share * points(low + 1);
}

Ground ShotGeometry::Table() const {
  double lowest = std::numeric_limits<double>::infinity();
  for (const Anchor& anchor : anchors_)
    lowest = std::min(lowest, frames_[anchor.animation].points.col(2).minCoeff());
  const auto heights = frames_[anchors_.front().animation].points.col(2);
  if (std::abs(lowest) < kStandsOnZero * (heights.maxCoeff() - heights.minCoeff())) lowest = 0;
  Eigen::Vector3d up = Eigen::Vector3d::Zero(), low = Eigen::Vector3d::Constant(1e300), high = -low;
  double height = 0;
  for (const Anchor& anchor : anchors_) up += PlaceOf(anchor).rotation.col(2);
  up.normalize();
  for (const Anchor& anchor : anchors_) {
    height += up.dot(PlaceOf(anchor) * Eigen::Vector3d(0, 0, lowest)) / SizeOf(anchors_);
    const PointsX3 points = PointsOfFrame(anchor.animation);
    low = low.cwiseMin(points.colwise().minCoeff().transpose());
    high = high.cwiseMax(points.colwise().maxCoeff().transpose());
  }
  Ground table;
  table.up = up;
  table.right = up.unitOrthogonal();
  table.back = up.cross(table.right);
  const Eigen::Vector3d middle = 0.5 * (low + high);
  table.origin = middle + (height - middle.dot(up)) * up;
  table.diagonal = std::max((high - low).norm(), 1e-9);
  table.reach = 0.4 * table.diagonal;
  return table;
}

}  // namespace keypose::composite
