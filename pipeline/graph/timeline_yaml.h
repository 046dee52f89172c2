// Converts the timeline of a project's YAML into the JSON that stages read.
#pragma once

#include <string>
#include <vector>

namespace YAML {
class Node;
}

namespace keypose::pipeline {

/// @param node  a list of keys (`rest`, or `{pose: rest, at: 0, hold: 0.5, ...}`), or a map with
/// such a list under `keys` and settings of the whole timeline beside it
/// @return {"schema": 2, "fps": fps, "keys": [...], ...} as in core/io/project/timeline_json.h,
/// with a key's `at` as "time"; empty if the list only gives the order of poses
std::string TimelineJson(const YAML::Node& node, double fps);

/// The same for keys of which only the order is known: frames have times by the project's rate.
/// Empty at the rate that stages take without a timeline, and for fewer than two keys.
std::string OrderJson(const std::vector<std::string>& poses, double fps);

}  // namespace keypose::pipeline
