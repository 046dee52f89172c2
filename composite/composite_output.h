// Writes the pictures of a finished shot, and what belongs to them.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "composite/composing/compose.h"
#include "composite/composing/join.h"
#include "composite/composite_input.h"
#include "views/film/sound.h"

namespace keypose::composite {

struct OutputOptions {
  ComposeOptions compose;
  std::string ending = ".png";  ///< of rendered pictures: .png, .tif, .tiff or .exr
  bool video = true, compare = true, blender = true;
  Sound sound;  ///< of shot.mp4, from its first picture on
};

/// How one key's render joins its filmed frame.
struct KeyJoin {
  int picture = 0;   ///< number in the finished shot
  std::string pose;  ///< empty: a located frame that shows no key pose
  JoinFigures figures;
};

struct Written {
  std::vector<KeyJoin> joins;
  int filmed_unchanged = 0;  ///< filmed frames whose copy has the same hash
};

/// Writes into the folder:
/// - 0000.png and on: the finished shot; filmed frames as they were filmed, under their own kind of
///   file; in-betweens as options.ending says, with the film's bits and colour profile
/// - layers/: character and shadow of the rendered pictures alone, with alpha
/// - plate.png (of a moving camera: plates/, those of the rendered pictures), shot.mp4, compare/
/// (filmed, rendered, difference), blender/, composite.json
/// @throws DiskError, ToolError; Cancelled
Written WriteShot(const std::filesystem::path& folder, const CompositeInput& input,
                  const ShotGeometry& geometry, const Film& film, const FilmLessons& lessons,
                  const OutputOptions& options, Progress* progress);

}  // namespace keypose::composite
