// The timeline: the time of each pose, the motion between poses, and constraints on it.
#pragma once

#include <Eigen/Core>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace keypose {

/// How the motion of a span (from one key to the next) runs.
enum class Travel {
  kStepped,  ///< holds the first key until the second
  kLinear,   ///< constant pace; the pace jumps at keys
  kSmooth    ///< the pace does not jump at keys (C1)
};

/// A CSS cubic-bezier(x1, y1, x2, y2): share of the time -> share of the way. The default is a
/// constant pace.
struct Ease {
  double x1 = 0, y1 = 0, x2 = 1, y2 = 1;
  bool even() const { return x1 == y1 && x2 == y2; }
  bool operator==(const Ease&) const = default;
};

/// Whole turns of a region in addition to its shortest rotation.
struct TimelineTurn {
  int turns = 0;                                   ///< right-handed about the axis
  Eigen::Vector3d axis = Eigen::Vector3d::Zero();  ///< in the first key of the span; zero: the axis
                                                   ///< of the region's own rotation
  bool operator==(const TimelineTurn&) const = default;
};

/// A key, and the span that begins with it.
struct TimelineKey {
  std::string pose;                 ///< for messages; may be empty
  std::optional<double> time_s;     ///< all keys have one, or none
  double hold_s = 0;                ///< the key is held for this time before its span begins
  Travel travel = Travel::kSmooth;  ///< of the span
  Ease ease;                        ///< of the span
  int step = 1;  ///< frames for which each mesh of the span is held; 2 is 'on twos'
  std::map<std::string, TimelineTurn> turns;  ///< of the span, by region
};

/// A set of vertices, the same in all keys: given by number, or as the first key's vertices within
/// a ball.
struct TimelineRegion {
  std::string name;
  std::vector<int> vertices;
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  double radius = 0;  ///< 0 when `vertices` are given
};

/// A region that moves on a straight line between its places in the keys. If both places are the
/// same, it does not move.
struct TimelinePin {
  std::string region;
  std::optional<double> from_s, to_s;  ///< times on the timeline; none: its begin or end
};

/// Positions that a region's centroid passes between keys.
struct TimelineTrajectory {
  struct Point {
    double time_s = 0;
    Eigen::Vector3d at = Eigen::Vector3d::Zero();
  };
  std::string region;
  std::vector<Point> points;  ///< rising times
};

/// Factor on the volume that the keys give, at a time. It is 1 at the keys.
struct TimelineVolume {
  double time_s = 0, ratio = 1;
};

struct Timeline {
  double fps = 24;
  /// the last key is the first pose again, and the pace does not jump where the loop closes
  bool loop = false;
  /// smooth spans may move beyond a key (rounder paths); else extremes lie at keys
  bool overshoot = false;
  std::optional<double> table_height;  ///< no vertex goes below this z
  /// whether the volume follows that of the keys; none: the stage's option decides
  std::optional<bool> keep_volume;
  std::vector<TimelineVolume> volume;  ///< squash and stretch, set by the artist
  std::vector<TimelineRegion> regions;
  std::vector<TimelinePin> pins;
  std::vector<TimelineTrajectory> trajectories;
  std::vector<TimelineKey> keys;  ///< two or more

  bool has_times() const { return !keys.empty() && keys.front().time_s.has_value(); }
  const TimelineRegion* FindRegion(const std::string& name) const {
    for (const TimelineRegion& region : regions)
      if (region.name == name) return &region;
    return nullptr;
  }
};

}  // namespace keypose
