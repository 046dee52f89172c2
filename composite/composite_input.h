// Reads what `composite` puts together.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "composite/composing/film_lessons.h"
#include "composite/film/film_files.h"
#include "composite/moving_plates.h"
#include "composite/scene/scene_plates.h"
#include "composite/scene_sequence.h"
#include "core/io/project/shot_io.h"
#include "core/stage/stage.h"

namespace keypose::composite {

/// How rendered pictures are stored, so that they go with those that were filmed.
struct FilmKind {
  int bits = 8;                 ///< per channel: 16 where a filmed picture has more than 8
  std::string profile;          ///< ICC colour profile of the first; empty: none
  std::string ending = ".png";  ///< of the files: .tif or .tiff beside filmed TIFFs
  bool keyed = false;           ///< filmed frames are transparent in part
};

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
  FilmKind kind;
  ImageF given_plate;                      ///< as Film::read gives pictures
  std::filesystem::path given_plate_file;  ///< of scene light, where it is not from a film
  Image8 holdout;
  std::shared_ptr<const SetGeometry> set;
  std::unique_ptr<MovingPlates> moving_plates;  ///< of a moving camera
  std::unique_ptr<ScenePlates> scene;           ///< of pictures that are scene light; else null
  std::unique_ptr<SceneSequence> sequence;      ///< a plate for each picture, where nothing was
                                                ///< filmed; else null
  int first_number = 0;                         ///< of the finished shot's pictures
};

/// @param fps  of the animation where its folder does not say
/// @throws InputError  pictures of other sizes than the shot's, a film without the shot's frames,
/// no texture coordinates, as many textures as keys are needed; and as the readers
CompositeInput ReadCompositeInput(StageContext& stage, double fps,
                                  const std::string& plate_colorspace);

/// The film for the algorithms; refers to `input`.
Film FilmOf(const CompositeInput& input, const ShotGeometry& geometry);

}  // namespace keypose::composite
