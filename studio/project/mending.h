// What a person smooths, pulls and fills on a pose's mesh: mending/POSE.json, which the step `mend`
// reads.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "studio/project/snapshot.h"

namespace keypose::studio {

/// - revision  of mending/POSE.json, "" without one
/// - problem   why it cannot be read, or why the pose has no mesh to mend; or ""
/// - mesh      changes when the mesh under the strokes does
/// - strokes   {tool, radius, strength, places: [{face, barycentric}], fault}; `fault`: why the
///             stroke does not lie on the mesh any more, or ""
/// - again     as AgainJson: what runs again when the strokes change
/// @throws UsageError  no such pose
nlohmann::json MendingJson(Snapshot& snapshot, const std::string& pose);

/// Writes the strokes; without one the file goes.
/// @param body  {revision, strokes}
/// @return {revision, strokes}, as MendingJson
/// @throws UsageError  a stroke that cannot be one
/// @throws ChangedMeanwhile
nlohmann::json SaveMending(Snapshot& snapshot, const std::string& pose, const nlohmann::json& body);

/// The mesh that is mended. @throws UsageError  there is none yet, and why
std::filesystem::path MeshToMend(Snapshot& snapshot, const std::string& pose);

/// That mesh as it would be after the strokes: float32, 3 a vertex, then 2 a stroke: how many
/// vertices it moved, and how far one of them.
/// @param body  {strokes}
/// @throws InputError  a stroke that cannot be done; names it
std::string DraftedMending(Snapshot& snapshot, const std::string& pose, const nlohmann::json& body);

}  // namespace keypose::studio
