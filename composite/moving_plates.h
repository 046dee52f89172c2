// The plates of a moving camera: a film of the empty set, such as motion control shoots.
#pragma once

#include <filesystem>
#include <memory>

#include "composite/composing/lessons.h"
#include "composite/film/film_files.h"
#include "composite/scene/scene_plates.h"

namespace keypose::composite {

/// Numbered as the film is, one for each filmed frame; or one for each picture of the finished
/// shot. A plate that is missing between two filmed frames is made from theirs.
class MovingPlates {
 public:
  /// Decodes a video; reads no picture yet.
  /// @param film_frames  numbers of the filmed frames, ascending
  /// @param scene  of plates that are scene light, else null; must outlive this object
  /// @throws InputError  a filmed frame without a plate; fewer plates than filmed frames
  MovingPlates(const std::filesystem::path& plates, const FilmPlan& plan,
               const std::vector<int>& film_frames, const Camera& camera, const ScenePlates* scene,
               Progress* progress);
  /// @throws InputError  of another size than the camera's
  MovingPlate At(int animation);
  const std::filesystem::path& first() const { return files_.pictures().front().path; }

  int made = 0;         ///< so far, from their neighbours
  double doubtful = 0;  ///< of the worst of them

 private:
  const std::filesystem::path* Find(int picture) const;
  ImageF Read(const std::filesystem::path& path) const;

  FilmFiles files_;
  int step_, start_, per_frame_;
  Camera camera_;
  const ScenePlates* scene_;
};

}  // namespace keypose::composite
