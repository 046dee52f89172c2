// The animation as numbered mesh files, one for each picture of the film.
#pragma once

#include <filesystem>
#include <string>

#include "core/values/progress.h"
#include "export/animation/scene.h"

namespace keypose::exporting {

/// What was written.
struct WrittenSequence {
  int files = 0;     ///< numbered files
  int pictures = 0;  ///< different ones among them
  /// Largest distance between a vertex of a file, as read again, and of its frame, over the
  /// diagonal.
  double error_over_diagonal = 0;
};

/// `frame_0000.obj`, ..., one for each of ShownFrames, so that a program that shows one file per
/// frame plays holds, repeats and the way back of a pingpong as the film does; numbers have more
/// digits if there are more than 10,000 files. All share `character.mtl`, written if there is a
/// texture and the mesh has texture coordinates; where each frame has a texture of its own, each
/// file has a material of its number with it. +y is up, as programs expect of OBJ files.
/// Numbers are the shortest that give back the same double. Vertices keep their order, and polygons
/// their corners.
///
/// @param folder        made if it does not exist
/// @param texture_path  of the material's texture, relative to the folder; empty: no material
/// @throws DiskError
WrittenSequence WriteObjSequence(const Scene& scene, const std::filesystem::path& folder,
                                 const std::string& texture_path, Progress* progress);

/// `frame_0000.ply`, ...: triangles in binary, with the axes of the frames, positions in double and
/// texture coordinates in single precision.
/// @throws DiskError
WrittenSequence WritePlySequence(const Scene& scene, const std::filesystem::path& folder,
                                 Progress* progress);

}  // namespace keypose::exporting
