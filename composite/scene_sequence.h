// A plate of its own for each picture of a shot in which nothing was filmed.
#pragma once

#include <filesystem>
#include <vector>

#include "composite/film/film_files.h"
#include "composite/plan/film_plan.h"
#include "composite/scene/scene_plates.h"

namespace keypose::composite {

/// Numbered plates of scene light, one for each picture of the finished shot. They are counted as
/// the pictures in which the shot was located.
class SceneSequence {
 public:
  /// @param scene   must outlive this object
  /// @param frames  of the animation
  /// @throws InputError  a picture without a plate
  SceneSequence(const std::filesystem::path& plates, const ScenePlates& scene,
                const FilmedShot& shot, const FilmPlan& plan, int frames);
  /// The plate's number in its name, of the animation's frame 0.
  int first_number() const { return numbers_.front(); }
  /// Of a frame of the animation.
  const std::filesystem::path& FileAt(int animation) const;
  ImageF At(int animation) const { return scene_.Light(FileAt(animation)); }
  int left_out() const { return left_out_; }  ///< plates that the animation does not reach

 private:
  const ScenePlates& scene_;
  std::vector<std::filesystem::path> files_;
  std::vector<int> numbers_;
  int left_out_ = 0;
};

}  // namespace keypose::composite
