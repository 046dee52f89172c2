#include "composite/scene_sequence.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/io/text/files.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose::composite {

namespace fs = std::filesystem;

SceneSequence::SceneSequence(const fs::path& plates, const ScenePlates& scene,
                             const FilmedShot& shot, const FilmPlan& plan, int frames)
    : scene_(scene) {
  const std::vector<FilmPicture> pictures = LightPictures(plates);
  const int first = plan.first_frame * plan.per_frame;
  for (int n = 0; n < frames; ++n) {
    const auto plate =
        std::find_if(pictures.begin(), pictures.end(),
                     [&](const FilmPicture& picture) { return picture.frame == first + n; });
    if (plate == pictures.end())
      throw InputError(fmt::format(
          "composite: frame {} of the animation has no plate: it needs the plate {} counted from "
          "{}, and {} are numbered to {}. Where nothing was filmed each picture has a plate of its "
          "own: the animation has {} frames at {:g} times the shot's {:g} a second; give locate "
          "the plates' rate (--fps), or one plate for all",
          n, first + n, PrintableName(pictures.front().path.filename()), PrintableName(plates),
          pictures.back().frame, frames, 1.0 * plan.per_frame, shot.fps));
    files_.push_back(plate->path);
    numbers_.push_back(plate->number);
  }
  left_out_ = SizeOf(pictures) - frames;
}

const fs::path& SceneSequence::FileAt(int animation) const {
  return files_[static_cast<std::size_t>(std::clamp(animation, 0, SizeOf(files_) - 1))];
}

}  // namespace keypose::composite
