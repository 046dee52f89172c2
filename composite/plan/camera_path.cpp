#include "composite/plan/camera_path.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/numbers/rotations.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose::composite {

CameraPath::CameraPath(std::vector<CameraKnot> knots) : knots_(std::move(knots)) {
  if (knots_.empty()) throw InputError("composite: the camera's way has no place to go by");
  for (int i = 0; i < SizeOf(knots_); ++i) {
    if (i > 0 && !(knots_[i].time > knots_[i - 1].time))
      throw InputError("composite: the places of the camera's way are not in the order of time");
    world_from_camera_.push_back(knots_[i].camera_from_world.Inverse());
  }
}

CameraPath::Place CameraPath::PlaceOf(int knot, int from) const {
  const Eigen::Quaterniond turn =
      world_from_camera_[from].rotation.conjugate() * world_from_camera_[knot].rotation;
  Place place;
  place << world_from_camera_[knot].translation, LogOf(turn);
  return place;
}

Rigid3 CameraPath::CameraOf(const Place& place, int from) const {
  const Eigen::Quaterniond turn = world_from_camera_[from].rotation * QuaternionOf(place.tail<3>());
  return Rigid3{turn.normalized(), place.head<3>()}.Inverse();
}

/// Of the parabola through the knot and its neighbours; at an end through the next two.
CameraPath::Place CameraPath::SpeedAt(int knot, int from) const {
  const int last = SizeOf(knots_) - 1;
  if (last < 2)
    return (PlaceOf(last, from) - PlaceOf(0, from)) / (knots_[last].time - knots_[0].time);
  const int middle = std::clamp(knot, 1, last - 1);
  const double before = knots_[middle].time - knots_[middle - 1].time,
               after = knots_[middle + 1].time - knots_[middle].time;
  const Place here = PlaceOf(middle, from);
  const Place arrives = (here - PlaceOf(middle - 1, from)) / before,
              leaves = (PlaceOf(middle + 1, from) - here) / after;
  const Place speed = (after * arrives + before * leaves) / (before + after);
  if (knot == middle) return speed;
  return knot < middle ? Place(2 * arrives - speed) : Place(2 * leaves - speed);
}

Rigid3 CameraPath::At(double time) const {
  const auto after = std::upper_bound(knots_.begin(), knots_.end(), time,
                                      [](double t, const CameraKnot& k) { return t < k.time; });
  if (after == knots_.begin()) return knots_.front().camera_from_world;
  const int i = static_cast<int>(after - knots_.begin()) - 1;
  if (after == knots_.end() || knots_[i].time == time) return knots_[i].camera_from_world;
  const double span = after->time - knots_[i].time, s = (time - knots_[i].time) / span;
  const double s2 = s * s, s3 = s2 * s;
  const Place place = (2 * s3 - 3 * s2 + 1) * PlaceOf(i, i) +
                      (s3 - 2 * s2 + s) * span * SpeedAt(i, i) +
                      (3 * s2 - 2 * s3) * PlaceOf(i + 1, i) + (s3 - s2) * span * SpeedAt(i + 1, i);
  return CameraOf(place, i);
}

CameraPath::Smooth CameraPath::SmoothAt(int knot) const {
  const int others[] = {knot - 2, knot - 1, knot + 1, knot + 2};
  Place place = Place::Zero();
  double squares = 1;
  for (const int i : others) {
    double weight = 1;  // Lagrange's
    for (const int j : others)
      if (j != i)
        weight *= (knots_[knot].time - knots_[j].time) / (knots_[i].time - knots_[j].time);
    place += weight * PlaceOf(i, knot);
    squares += weight * weight;
  }
  return {CameraOf(place, knot), std::sqrt(squares)};
}

}  // namespace keypose::composite
