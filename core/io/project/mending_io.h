// Reads and writes the strokes of the brush that mends a pose's mesh: mending/POSE.json.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/io/project/carry_log.h"
#include "core/surfaces/mend_stroke.h"
#include "core/values/mesh.h"

namespace keypose {

/// Strokes as they lie on the present mesh.
struct MendStrokes {
  std::vector<MendStroke> strokes;
  /// Of each stroke: why it does not lie on the mesh any more; empty when it does.
  std::vector<std::string> faults;
};

/// Reads strokes, and finds their places again on a mesh that was rebuilt since they were painted
/// (core/surfaces/carry.h). A place without a face, [x, y, z], is the nearest point of the mesh.
/// @param log  may be null; gets a note where strokes were carried over, and a warning where some
/// of their places are doubtful
/// @throws InputError  malformed: names the file and the stroke
MendStrokes ReadMendStrokes(const std::filesystem::path& path, const Mesh& mesh, CarryLog* log);

/// @throws InputError  strokes that do not lie on the mesh; names all, and says what to do
void RequireOnMesh(const MendStrokes& read, const std::filesystem::path& path);

/// What the file holds: the strokes, and the mesh that they are on.
/// @pre places are on the mesh's faces
std::string MendStrokesText(const Mesh& mesh, const std::vector<MendStroke>& strokes);

}  // namespace keypose
