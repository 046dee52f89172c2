#include "interpolate/timing/rules.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>

#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "interpolate/timing/easing.h"

namespace keypose::interpolation {

namespace {

std::string Seconds(double s) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g s", s);
  return text;
}

/// Converts a timeline's regions and times into vertices and spans.
class Reader {
 public:
  Reader(const Timeline& timeline, const Schedule& schedule, const PointsX3& points,
         const FacesX3& faces, const std::string& name)
      : timeline_(timeline), schedule_(schedule), points_(points), faces_(faces), name_(name) {
    for (const TimelineRegion& region : timeline.regions)
      vertices_[region.name] = VerticesOf(region);
  }

  HeldRegion Pinned(const TimelinePin& pin) const {
    HeldRegion held = Held(pin.region, true);
    const int from = pin.from_s ? KeyAt(*pin.from_s, pin.region) : 0,
              to = pin.to_s ? KeyAt(*pin.to_s, pin.region) : SpanCount();
    for (int k = from; k < to; ++k) held.spans[k] = 1;
    return held;
  }

  HeldRegion Led(const TimelineTrajectory& path) const {
    HeldRegion held = Held(path.region, false);
    held.waypoints.resize(SpanCount());
    for (const TimelineTrajectory::Point& point : path.points) {
      const auto [span, way] = WayAt(point.time_s, "trajectory of '" + path.region + "'");
      CheckRising(held.waypoints[span], way, "trajectory of '" + path.region + "'", point.time_s);
      held.waypoints[span].push_back({way, point.at});
      held.spans[span] = 1;
    }
    return held;
  }

  std::vector<std::vector<Waypoint<double>>> Volume() const {
    std::vector<std::vector<Waypoint<double>>> volume(SpanCount());
    for (const TimelineVolume& point : timeline_.volume) {
      const auto [span, way] = WayAt(point.time_s, "volume");
      CheckRising(volume[span], way, "volume", point.time_s);
      volume[span].push_back({way, std::log(point.ratio)});
    }
    return volume;
  }

  std::vector<TurnOverride> TurnsOf(const Span& span) const {
    std::vector<TurnOverride> overrides;
    for (const auto& [region, turn] : span.turns)
      if (turn.turns != 0) overrides.push_back({region, FacesOf(region), turn.turns, turn.axis});
    return overrides;
  }

 private:
  int SpanCount() const { return SizeOf(schedule_.spans); }

  std::vector<int> VerticesOf(const TimelineRegion& region) const {
    std::vector<int> vertices = region.vertices;
    for (const int v : vertices)
      if (v >= points_.rows())
        throw InputError(name_ + ": region '" + region.name + "' has vertex " + std::to_string(v) +
                         ", but the keys have " + std::to_string(points_.rows()) +
                         "; it was picked on another mesh");
    for (Eigen::Index v = 0; v < points_.rows() && region.vertices.empty(); ++v)
      if ((points_.row(v).transpose() - region.center).norm() <= region.radius)
        vertices.push_back(static_cast<int>(v));
    std::sort(vertices.begin(), vertices.end());
    vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
    if (vertices.empty())
      throw InputError(name_ + ": region '" + region.name +
                       "' holds no vertex of the first key: its nearest is " +
                       std::to_string(NearestDistance(region.center)) +
                       " from the center; move it or make it larger");
    return vertices;
  }

  double NearestDistance(const Eigen::Vector3d& center) const {
    return (points_.rowwise() - center.transpose()).rowwise().norm().minCoeff();
  }

  /// Listed vertices: the faces between them. A ball: the face nearest to its centre; it represents
  /// its limb.
  std::vector<int> FacesOf(const std::string& name) const {
    const TimelineRegion& region = *timeline_.FindRegion(name);
    if (region.vertices.empty()) return {NearestFace(region.center)};
    const std::vector<int>& vertices = vertices_.at(name);
    const auto in = [&](int v) { return std::binary_search(vertices.begin(), vertices.end(), v); };
    std::vector<int> faces;
    for (Eigen::Index f = 0; f < faces_.rows(); ++f)
      if (in(faces_(f, 0)) && in(faces_(f, 1)) && in(faces_(f, 2)))
        faces.push_back(static_cast<int>(f));
    if (faces.empty())
      throw InputError(name_ + ": region '" + name +
                       "' turns, but no face has all corners in it; list more vertices");
    return faces;
  }

  int NearestFace(const Eigen::Vector3d& center) const {
    int nearest = 0;
    double least = std::numeric_limits<double>::infinity();
    for (Eigen::Index f = 0; f < faces_.rows(); ++f) {
      const Eigen::Vector3d middle =
          (points_.row(faces_(f, 0)) + points_.row(faces_(f, 1)) + points_.row(faces_(f, 2)))
              .transpose() /
          3;
      if ((middle - center).squaredNorm() < least) {
        least = (middle - center).squaredNorm();
        nearest = static_cast<int>(f);
      }
    }
    return nearest;
  }

  HeldRegion Held(const std::string& region, bool every_vertex) const {
    return {region, vertices_.at(region), every_vertex, std::vector<char>(SpanCount(), 0), {}};
  }

  double FrameAt(double time_s) const { return (time_s - schedule_.start_s) * schedule_.fps; }

  int KeyAt(double time_s, const std::string& region) const {
    const int frame = static_cast<int>(std::lround(std::clamp(FrameAt(time_s), -1e8, 1e8)));
    for (int k = 0; k <= SpanCount(); ++k) {
      const int hold = k < SpanCount() ? schedule_.spans[k].hold : schedule_.end_hold;
      if (frame >= schedule_.key_frames[k] && frame <= schedule_.key_frames[k] + hold) return k;
    }
    throw InputError(name_ + ": the pin of '" + region + "' begins or ends at " + Seconds(time_s) +
                     ", where no key is; a pin holds from key to key, else its region would jump");
  }

  /// Span and share of its way at a time.
  std::pair<int, double> WayAt(double time_s, const std::string& what) const {
    const double frame = FrameAt(time_s);
    for (int k = 0; k < SpanCount(); ++k) {
      const Span& span = schedule_.spans[k];
      const double start = schedule_.key_frames[k] + span.hold,
                   share = (frame - start) / span.frames;
      if (span.travel == Travel::kStepped || !(share > 1e-6 && share < 1 - 1e-6)) continue;
      const double way = EaseAt(span.ease, share);
      if (!(way > 0 && way < 1))
        throw InputError(name_ + ": the " + what + " has a point at " + Seconds(time_s) +
                         ", where the span's ease swings beyond its keys");
      return {k, way};
    }
    throw InputError(
        name_ + ": the " + what + " has a point at " + Seconds(time_s) +
        ", which does not lie between two keys that move (keys themselves are kept as they are)");
  }

  template <class Value>
  void CheckRising(const std::vector<Waypoint<Value>>& so_far, double way, const std::string& what,
                   double time_s) const {
    if (so_far.empty() || way > so_far.back().way + 1e-9) return;
    throw InputError(name_ + ": the " + what + " has a point at " + Seconds(time_s) +
                     ", where the span's ease does not move on");
  }

  const Timeline& timeline_;
  const Schedule& schedule_;
  const PointsX3& points_;
  const FacesX3& faces_;
  const std::string& name_;
  std::map<std::string, std::vector<int>> vertices_;
};

}  // namespace

Rules PlainRules(const Schedule& schedule, bool keep_volume) {
  Rules rules;
  rules.keep_volume = keep_volume;
  rules.turns.resize(schedule.spans.size());
  return rules;
}

Rules RulesFrom(const Timeline& timeline, const Schedule& schedule, const PointsX3& first_key,
                const FacesX3& faces, bool keep_volume, const std::string& name) {
  const Reader reader(timeline, schedule, first_key, faces, name);
  Rules rules;
  rules.keep_volume = timeline.keep_volume.value_or(keep_volume);
  rules.table_height = timeline.table_height;
  for (const TimelinePin& pin : timeline.pins) rules.held.push_back(reader.Pinned(pin));
  for (const TimelineTrajectory& path : timeline.trajectories)
    rules.held.push_back(reader.Led(path));
  for (const Span& span : schedule.spans) rules.turns.push_back(reader.TurnsOf(span));
  if (!timeline.volume.empty()) rules.log_volume = reader.Volume();
  return rules;
}

}  // namespace keypose::interpolation
