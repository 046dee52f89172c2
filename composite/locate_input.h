// Reads what locate needs: meshes, pictures, mattes, clicks, and what is known of the lens.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "composite/film/film_files.h"
#include "composite/locate_options.h"
#include "composite/locating/search/locate_shot.h"
#include "core/io/project/shot_io.h"
#include "core/stage/stage.h"

namespace keypose::composite {

/// The input, and how to write its result.
struct LocateInput {
  std::unique_ptr<FilmFiles> film;
  double fps = 12;  ///< of the film
  Mesh mesh;        ///< the first pose's
  Image8 texture;
  ShotInput shot;                       ///< points to the two above; pictures are reduced
  std::vector<FilmPicture> pictures;    ///< one for each of shot.frames
  std::vector<std::string> pose_names;  ///< one for each of shot.poses; may be empty texts
  Camera camera;                        ///< of the whole pictures
  double scale = 1;                     ///< of the reduced pictures over the whole ones
  std::vector<std::string> notes;

  LocateInput() = default;
  LocateInput(const LocateInput&) = delete;  // shot points into this object
  LocateInput& operator=(const LocateInput&) = delete;
};

/// @throws InputError  pictures of several sizes; mattes or meshes that do not fit; malformed
/// clicks; a frame whose pose is not known
/// @throws UsageError  neither frames nor mesh, or both; --shows or --poses that cannot be read
void ReadLocateInput(StageContext& stage, const LocateStageOptions& options, LocateInput& input);

}  // namespace keypose::composite
