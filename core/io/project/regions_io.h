// Reads and writes regions of a timeline together with the mesh whose vertices they list.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/io/project/carry_log.h"
#include "core/values/mesh.h"
#include "core/values/timeline.h"

namespace keypose {

/// @param mesh  the mesh of the first key
/// @throws InputError  a vertex that the mesh does not have; names the region
void WriteRegions(const std::filesystem::path& path, const Mesh& mesh,
                  const std::vector<TimelineRegion>& regions);

/// All regions of a file, by name, adapted to a mesh as FollowRegions does.
/// @param path  written by WriteRegions
/// @param mesh  null: as they were written
/// @throws InputError  malformed, or regions that could not be transferred; names them
std::vector<TimelineRegion> RegionsOn(const std::filesystem::path& path, const Mesh* mesh);

/// Adapts the timeline's regions to the first key's mesh.
///
/// A list of vertices stays valid while the keys have the same faces as when the region was bound;
/// the pose does not matter. On another template the list becomes the vertices at the same places,
/// and a ball gets its centre and radius in the new frame. Lists that no file binds to a mesh are
/// used unchanged, with a warning.
/// @param path  written by WriteRegions; empty: none
/// @throws InputError  malformed, a list that differs from the bound one, or regions that could not
/// be transferred; names them
void FollowRegions(const std::filesystem::path& path, const Mesh& first_key, Timeline& timeline,
                   CarryLog* log);

}  // namespace keypose
