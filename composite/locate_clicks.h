// Reads clicks.json: pairs of a pixel of a filmed picture and a place on the mesh.
#pragma once

#include <filesystem>
#include <vector>

#include "composite/locating/clicks/clicked_place.h"
#include "core/values/mesh.h"

namespace keypose::composite {

struct FrameClick {
  int frame = -1;  ///< of the film; -1: its first picture
  Click click;
};

/// Format: docs/file-formats.md.
/// @throws InputError  malformed; a vertex, face or pixel that does not exist; names the click
std::vector<FrameClick> ReadClicks(const std::filesystem::path& path, const Mesh& mesh, int width,
                                   int height);

}  // namespace keypose::composite
