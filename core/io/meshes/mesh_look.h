// What of a mesh's materials and texture coordinates is lost or shows wrongly in what Keypose
// writes: one material with one texture, which covers the unit square.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/values/mesh.h"

namespace keypose {

/// Sentences for warnings: several materials (OBJ), faces beyond the unit square (UDIM tiles, a
/// texture that repeats), faces without texture coordinates. Empty for a mesh without any.
/// @param path  the file that the mesh was read from
/// @throws DiskError
std::vector<std::string> LookWarnings(const std::filesystem::path& path, const Mesh& mesh);

}  // namespace keypose
