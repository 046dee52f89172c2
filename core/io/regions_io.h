// Regions of a timeline, bound to the mesh that their vertices were counted on.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/io/carry_log.h"
#include "core/mesh.h"
#include "core/timeline.h"

namespace keypose {

/// @param mesh  that of the first key
/// @throws InputError  a vertex that the mesh does not have; names the region
void WriteRegions(const std::filesystem::path& path, const Mesh& mesh,
                  const std::vector<TimelineRegion>& regions);

/// Makes the timeline's regions fit the first key.
///
/// A list of vertices holds as long as the keys have the faces that they had when it was bound,
/// whatever the pose. On another template it takes the vertices at the same places, and a ball its
/// place and size in the new frame. Lists that no file binds are taken as they are, with a warning.
/// @param path  written by WriteRegions; empty: none
/// @throws InputError  malformed, a list that is another than the bound one, or regions that could
/// not be carried over; names them
void FollowRegions(const std::filesystem::path& path, const Mesh& first_key, Timeline& timeline,
                   CarryLog* log);

}  // namespace keypose
