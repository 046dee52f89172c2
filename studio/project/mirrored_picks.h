// Landmarks of one half of a symmetric figure, on the other half.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "studio/project/snapshot.h"

namespace keypose::studio {

/// Picks of the template that have no partner on its other half, mirrored:
/// {"misfit": mean distance of the halves over the diagonal, "mirrored": [{"of", "source",
/// "target", "off"}]}. `of`: the pick's name; `source`, `target`: {face, barycentric} on the
/// template and on the pose. The target is where the pose's net has the mirrored place, null before
/// there is one; `off`: how far that is from the scan, over the diagonal.
/// @throws UsageError  no such pose, no mesh yet, or halves that differ too much
nlohmann::json MirroredPicksJson(Snapshot& snapshot, const std::string& pose);

}  // namespace keypose::studio
