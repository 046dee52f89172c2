// The timeline as a project writes it in YAML, turned into the JSON that stages read.
#pragma once

#include <string>

namespace YAML {
class Node;
}

namespace keypose::pipeline {

/// @param node  a list of keys (`rest`, or `{pose: rest, at: 0, hold: 0.5, ...}`), or a map with
/// such a list under `keys` and what holds for
///              the whole timeline beside it
/// @return {"schema": 2, "fps": fps, "keys": [...], ...} as core/io/timeline.h has it, a key's `at`
/// as "time"; empty when the list says
///         nothing but the order of poses
std::string TimelineJson(const YAML::Node& node, double fps);

}  // namespace keypose::pipeline
