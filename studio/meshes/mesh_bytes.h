// Meshes and clouds as the bytes that the page draws (studio/web/src/view/mesh_data.ts reads them).
#pragma once

#include <filesystem>
#include <string>

#include "core/values/mesh.h"

namespace keypose::studio {

/// 'KPM1', then as little-endian uint32 the number of vertices, of faces, and flags (1: texture
/// coordinates, 2: colours); then positions (float32, 3 a vertex), indices (uint32, 3 a face),
/// texture coordinates (float32, 2 a corner, v up), colours (4 bytes a vertex, the last 0).
std::string MeshBytes(const Mesh& mesh);
/// The same without faces. At most `most` points, spread evenly.
std::string CloudBytes(const PointCloud& cloud, int most);

/// The distance of each vertex of `mesh` to the surface of `scan`, over the scan's diagonal;
/// float32 each.
std::string FitBytes(const Mesh& mesh, const Mesh& scan);

}  // namespace keypose::studio
