// The colours of a performance's moving mesh: a texture for each frame as `video3d` has painted it,
// and the scan's own.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "core/values/mesh.h"
#include "studio/project/snapshot.h"

namespace keypose::studio {

/// The shot's first frame with the texture coordinates that its textures were painted in: those of
/// the step `layout`, where it has run on these faces, else the frame's own.
Mesh FrameWithLayout(Snapshot& snapshot, const std::string& shot, Mesh frame);

/// Which colours there are:
///   "own": "texture" (a picture), "vertices" (colours of the scan's vertices) or ""
///   "video": {"width", "height", "version"} of the textures, or null
///   "own_problem", "video_problem": why there are none, and what to do; else ""
/// @param first  the shot's first frame, as it is in its folder
nlohmann::json FrameColoursJson(Snapshot& snapshot, const std::string& shot, const Mesh& first,
                                std::size_t frames);

/// The texture that `video3d` painted for a frame.
/// @throws UsageError  no such shot @throws NotFound  no such texture (yet)
std::filesystem::path FrameTexture(Snapshot& snapshot, const std::string& shot, int frame);

/// The scan's own texture.
/// @throws UsageError  no such shot
/// @throws NotFound  the project names none; it is gone, or outside of the project
std::filesystem::path OwnTexture(Snapshot& snapshot, const std::string& shot);

}  // namespace keypose::studio
