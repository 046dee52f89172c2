// STL, as text and binary, with the colours that programs put into the binary one.
#pragma once

#include <filesystem>
#include <string_view>

#include "core/io/meshes/noted_mesh.h"

namespace keypose {

/// Whether a file is binary STL of just the length that its count of triangles says.
/// @param head  its first bytes, at least 84 where it has so many
bool IsWholeBinaryStl(const std::filesystem::path& path, std::string_view head);

/// Whether a file that is of no known kind is binary STL that was cut, or that has bytes behind
/// its triangles: by its ending, or since its first triangles have unit normals.
bool LooksLikeBinaryStl(const std::filesystem::path& path, std::string_view head);

/// Corners with equal coordinates become one vertex, in the order of the file. Text may be of any
/// case and hold several solids. Colours of binary files: where the header has `COLOR=`, as Magics
/// writes them, else as VisCAM and SolidView do; they become those of vertices (face_colors.h).
/// Bytes behind the triangles are noted.
/// @throws DiskError   cannot be opened
/// @throws InputError  malformed, truncated; says where
NotedMesh ReadStl(const std::filesystem::path& path);

}  // namespace keypose
