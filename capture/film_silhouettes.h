// Masks of the films of cameras that have no picture of the empty set.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "capture/films/film_model.h"
#include "core/stage/stage.h"
#include "views/shot/shot.h"

namespace keypose::capture {

struct FilmSilhouettesRequest {
  int mask_px = 512;    ///< working size, longer side
  std::string figure;   ///< strokes, as ParseFigureStrokes reads them
  bool network = true;  ///< ask the network where it is installed
};

struct FilmSilhouettesCount {
  int masks = 0, empty = 0;
};

/// Learns each camera's film and writes masks/CAMERA/000.png and on.
/// @param cameras   those without a picture of the empty set
/// @param calibration  of all cameras, to compare their masks in space; empty: they are not
/// compared
/// @param out       the folder masks
/// @throws InputError  a camera in whose film nothing moves; names it
/// @throws UsageError  a stroke in a camera or a frame that the films do not have
FilmSilhouettesCount WriteFilmSilhouettes(StageContext& stage,
                                          const std::vector<ShotCamera>& cameras,
                                          const std::filesystem::path& calibration,
                                          const FilmSilhouettesRequest& request,
                                          const std::filesystem::path& out);

}  // namespace keypose::capture
