// The artist's constraints between keys, as vertices and spans.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/values/mesh.h"
#include "core/values/timeline.h"
#include "interpolate/timing/frame_schedule.h"
#include "interpolate/timing/spline.h"
#include "interpolate/turns/turns.h"

namespace keypose::interpolation {

/// A region that is held in some spans.
struct HeldRegion {
  std::string name;
  std::vector<int> vertices;  ///< sorted, unique
  bool every_vertex = true;   ///< else only the centroid is held
  std::vector<char> spans;    ///< 1 where it is held
  /// of the centroid, for each span
  std::vector<std::vector<Waypoint<Eigen::Vector3d>>> waypoints;
};

struct Rules {
  std::vector<HeldRegion> held;
  std::vector<std::vector<TurnOverride>> turns;  ///< for each span
  std::optional<double> table_height;            ///< z
  bool keep_volume = true;
  /// for each span: log of the volume over the volume that follows from the keys
  std::vector<std::vector<Waypoint<double>>> log_volume;
};

/// Rules without a timeline: the volume alone.
Rules PlainRules(const Schedule& schedule, bool keep_volume);

/// @param keep_volume  default, where the timeline has no setting
/// @param first_key    regions given as balls are measured in it
/// @throws InputError  a region without vertices or with a vertex that does not exist; a pin that
/// does not begin and end at keys; a waypoint outside the spans, in a hold or a stepped span, or on
/// a span whose ease runs backwards; names it
Rules RulesFrom(const Timeline& timeline, const Schedule& schedule, const PointsX3& first_key,
                const FacesX3& faces, bool keep_volume, const std::string& name);

}  // namespace keypose::interpolation
