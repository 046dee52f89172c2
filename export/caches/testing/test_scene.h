// Animations with known truth for the tests of formats.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "export/animation/scene.h"

namespace keypose::exporting {

struct TestSceneOptions {
  /// per frame, how far the tube is bent; equal numbers give equal frames
  std::vector<int> bends{0, 1, 2, 3};
  std::vector<char> stands;  ///< as in Clip; empty: as MakeClip decides
  PlaybackOptions playback{10, 0, "none"};
  bool z_up = true;
  bool with_uvs = true;  ///< a seam runs along the tube; with a texture
  int segments = 16, rings = 8;
};

/// A tube that bends to one side and twists. No two of its axes look alike.
Scene TestScene(const TestSceneOptions& options = {});

/// Writes the files, and the scene's textures in textures/, below the folder.
void WriteFiles(const FormatFiles& made, const Scene& scene, const std::filesystem::path& folder);

/// Writes what a reader must find, for programs in other languages: `truth.json` with counts, and
/// as raw arrays `points.f64` (per shown frame and vertex, +y up), `faces.i32`, `corner_uvs.f64`
/// (per face corner, v up), `split_source.i32` (per split vertex) and `split_normals.f64` (per
/// shown frame and split vertex, +y up).
void WriteTruth(const Scene& scene, const std::filesystem::path& folder);

}  // namespace keypose::exporting
