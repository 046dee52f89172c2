// Reads what `composite` puts together.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "composite/composing/film_lessons.h"
#include "composite/film/film_files.h"
#include "composite/passing_plates.h"
#include "core/io/shot_io.h"
#include "core/stage/stage.h"

namespace keypose::composite {

/// All of a shot, read and checked.
struct CompositeInput {
  FilmedShot shot;
  AnimationTimes times;
  std::vector<Mesh> frames;
  Looks looks;
  std::unique_ptr<FilmFiles> film_files;
  std::vector<FilmPicture> film;  ///< the filmed pictures that teach; may be empty
  bool film_stays = false;        ///< they are pictures of the finished shot too
  FilmPlan plan;
  Image8 given_plate, holdout;
  std::shared_ptr<const SetGeometry> set;
  std::unique_ptr<PassingPlates> passing;  ///< of a moving camera
};

/// @param fps  of the animation where its folder does not say
/// @throws InputError  pictures of other sizes than the shot's, a film without the shot's frames,
/// no texture coordinates, as many textures as keys are needed; and as the readers
CompositeInput ReadCompositeInput(StageContext& stage, double fps);

/// The film for the algorithms; refers to `input`.
Film FilmOf(const CompositeInput& input, const ShotGeometry& geometry);

}  // namespace keypose::composite
