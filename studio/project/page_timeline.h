// The timeline as the page edits it, and back into pipeline.yaml.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "studio/project/snapshot.h"

namespace keypose::studio {

/// Keys with times in seconds, also where the file only gives the order of poses; then the times
/// are those that `interpolate` would choose.
nlohmann::json TimelineToPage(Snapshot& snapshot);

/// Writes fps, loop, step and the keys. Fields that the page does not know stay as they are in the
/// file, also within a key.
/// @param timeline  as TimelineToPage gives it
/// @throws ChangedMeanwhile, UsageError, InputError  what is wrong with the timeline
void SaveTimeline(Snapshot& snapshot, const nlohmann::json& timeline);

/// Takes painted regions over into the timeline, where pins and turns name them. Does nothing if
/// the timeline has none of them.
/// @param painted  vertices by the region's name
void FollowPaintedRegions(Snapshot& snapshot, const nlohmann::json& painted);

}  // namespace keypose::studio
