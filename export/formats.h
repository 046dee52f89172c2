// The formats that the export stage offers, and what each writes.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "core/stage/stage.h"
#include "export/animation/scene.h"
#include "export/film/film.h"
#include "export/gltf/few_targets.h"
#include "views/film/sound.h"

namespace keypose::exporting {

/// The names of all formats, in the order in which they are written.
std::vector<std::string> FormatNames();

/// How long a format takes to write, roughly, in rendered pictures: for progress.
double FormatCost(const std::string& format, const Scene& scene);

/// Of `character.glb`.
struct LightGlbOptions {
  double error = 1e-4;  ///< largest distance of a vertex, as share of the diagonal, > 0
  int texture = 2048;   ///< largest width and height of a texture, px
};

/// Options that only some formats have.
struct FormatOptions {
  /// of the GLB files: "jpeg", "png", "none", or "auto": none in `glb`, jpeg in the others
  std::string pose_textures = "auto";
  LightGlbOptions light;
  FewTargetsOptions few;
  FilmOptions film = {.azimuth_deg = 0};
  std::string background = "paper";  ///< of the film: FilmColor
  Sound sound;                       ///< of the film and the sheet, from the first picture on
  bool pictures = false;             ///< also the film's pictures, as PNG with alpha
  std::string turntable;             ///< frame number or name of a key; empty: the first key
};

/// What was written for a format.
struct WrittenFormat {
  std::string format;
  std::vector<std::string> files;   ///< below the animation's folder; a folder ends in '/'
  double error_over_diagonal = -1;  ///< see FormatFiles; below 0: the format has no vertices
  std::map<std::string, double> measured;
};

/// Writes one format into the output `animation`.
///
/// @param texture_names  file names of the scene's textures, in the folder textures/
/// @throws InputError  the scene does not fit into the format
/// @throws DiskError   a file cannot be written
WrittenFormat WriteFormat(const std::string& format, const Scene& scene,
                          const std::vector<std::string>& texture_names,
                          const FormatOptions& options, StageContext& stage, Progress* progress);

}  // namespace keypose::exporting
