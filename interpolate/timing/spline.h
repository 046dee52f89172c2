// Smooth paths through keys: each pair's own path plus a cubic correction of its end velocities.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/values/size_of.h"
#include "interpolate/timing/frame_schedule.h"

namespace keypose::interpolation {

/// A path between two keys that has velocity u0 at its start and u1 at its end (per span) gets
/// velocities v0 and v1 when start(s) (v0 - u0) + end(s) (v1 - u1) is added. Both weights vanish at
/// 0 and 1; start'(0) = end'(1) = 1 and start'(1) = end'(0) = 0 (cubic Hermite basis).
struct HermiteWeights {
  explicit HermiteWeights(double s) : start(s * (1 - s) * (1 - s)), end(-s * s * (1 - s)) {}
  double start, end;
};

/// Velocity at a key from the mean velocities of the spans before and after it, and their durations
/// (> 0).
///
/// Clamped: the weighted harmonic mean of Fritsch & Butland (1984), which never overshoots a key.
/// The form for vectors does not depend on their basis. For parallel vectors it is the scalar rule;
/// for vectors at right angles or more it is zero (the key is an extreme); in between it is
/// continuous. Zero if either velocity is zero: a hold stays still.
/// Round (overshoot): the parabola through three keys; also zero if either velocity is zero.
template <class Vector>
Vector VelocityAtKey(const Vector& before, const Vector& after, double time_before,
                     double time_after, bool overshoot) {
  const double a2 = before.squaredNorm(), b2 = after.squaredNorm();
  if (a2 == 0 || b2 == 0) return Vector::Zero();
  if (overshoot) return (time_after * before + time_before * after) / (time_before + time_after);
  const double dot = before.dot(after);
  if (dot <= 0) return Vector::Zero();
  const double w_before = 2 * time_after + time_before, w_after = time_after + 2 * time_before;
  const Vector mixed = w_before * after + w_after * before;
  return ((w_before + w_after) * dot / mixed.squaredNorm()) * mixed;
}

inline double VelocityAtKey(double before, double after, double time_before, double time_after,
                            bool overshoot) {
  using One = Eigen::Matrix<double, 1, 1>;
  return VelocityAtKey(One(before), One(after), time_before, time_after, overshoot)[0];
}

/// Velocities of one quantity at the ends of each span, per span.
template <class Value>
struct EndVelocities {
  std::vector<Value> start, end;  ///< spans
};

/// Pace of a span at its ends [spans per frame]: 0 where it eases out of or into a key.
struct SpanPace {
  double start = 0, end = 0;
};
SpanPace PaceOf(const Span& span);

/// The motion on one side of a key, for smooth velocities.
enum class Meeting {
  kFree,    ///< the span keeps its own velocity there: an end of the timeline, or a neighbour that
            ///< needs none
  kStill,   ///< it comes to rest or starts from rest: a hold, or a stepped span after it
  kSmooth,  ///< both spans have the same velocity
};
/// Of key k, 0 <= k <= spans; in a loop key 0 and the last are one key. `before` is for the span
/// that ends there, `after` for the other.
struct KeyMeeting {
  Meeting before = Meeting::kFree, after = Meeting::kFree;
};
KeyMeeting MeetingAt(const Schedule& schedule, int key);

/// Whether any span is smoothed.
bool AnySmooth(const Schedule& schedule);

/// Velocities at the ends of spans that make a quantity's path C1 in time, given the spans' own.
///
/// @param own   velocities of each span's own path at its ends, per span; for straight paths both
/// are the difference of the keys
/// @return the wanted velocities; equal to `own` where nothing is smoothed, so that the path of a
/// single span does not change
template <class Value>
EndVelocities<Value> SmoothVelocities(const Schedule& schedule, const EndVelocities<Value>& own) {
  EndVelocities<Value> smooth = own;
  const int spans = SizeOf(schedule.spans);
  for (int key = 0; key <= spans; ++key) {
    const KeyMeeting meeting = MeetingAt(schedule, key);
    const int before = key > 0 ? key - 1 : spans - 1, after = key < spans ? key : 0;
    const Span &in = schedule.spans[before], &out = schedule.spans[after];
    const double pace_in = PaceOf(in).end, pace_out = PaceOf(out).start;
    // A span that eases out with slope zero arrives at rest with any path velocity, so it keeps its
    // own.
    if (meeting.before == Meeting::kStill && pace_in != 0) smooth.end[before] = own.end[before] * 0;
    if (meeting.after == Meeting::kStill && pace_out != 0)
      smooth.start[after] = own.start[after] * 0;
    if (meeting.before != Meeting::kSmooth) continue;
    const Value velocity =
        VelocityAtKey(Value(own.end[before] * pace_in), Value(own.start[after] * pace_out),
                      in.frames, out.frames, schedule.overshoot);
    if (pace_in != 0) smooth.end[before] = velocity / pace_in;
    if (pace_out != 0) smooth.start[after] = velocity / pace_out;
  }
  return smooth;
}

/// A value to pass through within a span.
template <class Value>
struct Waypoint {
  double way = 0;  ///< share of the span's way, in (0, 1)
  Value value;
};

/// A quantity through its values at the keys and through waypoints between them. It is linear for a
/// single span without waypoints, C1 where spans meet smoothly and at waypoints, and exactly
/// constant between equal keys.
template <class Value>
class SpanSpline {
 public:
  SpanSpline() = default;
  /// @param keys       one value for each key
  /// @param waypoints  for each span, in rising order; or empty
  SpanSpline(const Schedule& schedule, const std::vector<Value>& keys,
             const std::vector<std::vector<Waypoint<Value>>>& waypoints = {}) {
    EndVelocities<Value> own;
    for (std::size_t k = 0; k + 1 < keys.size(); ++k) {
      std::vector<Waypoint<Value>> knots = {{0, keys[k]}};
      if (k < waypoints.size()) knots.insert(knots.end(), waypoints[k].begin(), waypoints[k].end());
      knots.push_back({1, keys[k + 1]});
      spans_.push_back({std::move(knots), {}});
      own.start.push_back(Secant(spans_.back().knots, 0));
      own.end.push_back(Secant(spans_.back().knots, spans_.back().knots.size() - 2));
    }
    const EndVelocities<Value> smooth = SmoothVelocities(schedule, own);
    for (std::size_t k = 0; k < spans_.size(); ++k)
      SetVelocities(spans_[k], smooth.start[k], smooth.end[k], schedule.overshoot);
  }

  Value At(int span, double way) const {
    const std::vector<Waypoint<Value>>& knots = spans_[span].knots;
    std::size_t i = 0;
    while (i + 2 < knots.size() && way > knots[i + 1].way) ++i;
    const double length = knots[i + 1].way - knots[i].way, s = (way - knots[i].way) / length;
    const HermiteWeights weights(s);
    const Value difference = knots[i + 1].value - knots[i].value;
    const std::vector<Value>& velocities = spans_[span].velocities;
    return knots[i].value + s * difference + weights.start * (length * velocities[i] - difference) +
           weights.end * (length * velocities[i + 1] - difference);
  }

 private:
  struct Piece {
    std::vector<Waypoint<Value>> knots;
    std::vector<Value> velocities;  ///< per span, at each knot
  };
  static Value Secant(const std::vector<Waypoint<Value>>& knots, std::size_t i) {
    return (knots[i + 1].value - knots[i].value) / (knots[i + 1].way - knots[i].way);
  }
  static void SetVelocities(Piece& piece, const Value& start, const Value& end, bool overshoot) {
    piece.velocities.push_back(start);
    for (std::size_t i = 1; i + 1 < piece.knots.size(); ++i)
      piece.velocities.push_back(VelocityAtKey(Secant(piece.knots, i - 1), Secant(piece.knots, i),
                                               piece.knots[i].way - piece.knots[i - 1].way,
                                               piece.knots[i + 1].way - piece.knots[i].way,
                                               overshoot));
    piece.velocities.push_back(end);
  }
  std::vector<Piece> spans_;
};

}  // namespace keypose::interpolation
