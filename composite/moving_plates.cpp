#include "composite/moving_plates.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "composite/plate/plate_between.h"
#include "core/io/pictures/image_levels.h"
#include "core/io/text/files.h"
#include "core/values/errors.h"

namespace keypose::composite {

namespace fs = std::filesystem;

MovingPlates::MovingPlates(const fs::path& plates, const FilmPlan& plan,
                           const std::vector<int>& film_frames, const Camera& camera,
                           const ScenePlates* scene, Progress* progress)
    : files_(plates),
      start_(plan.start),
      per_frame_(plan.per_frame),
      camera_(camera),
      scene_(scene) {
  const std::vector<FilmPicture>& pictures = files_.pictures();
  if (pictures.size() < 2)
    throw InputError(fmt::format(
        "composite: the camera of this shot moves, so one plate ({}) does not do: pass a folder of "
        "numbered plates or a video, one for each filmed frame or one for each picture of the "
        "finished shot, such as motion control shoots of the empty set",
        PrintableName(plates)));
  step_ = PlatesAFrame(pictures.back().frame, film_frames.back()) == 1 ? per_frame_ : 1;
  files_.DecodeAll(progress);
  for (const int frame : film_frames)
    if (!Find(frame * per_frame_))
      throw InputError(fmt::format(
          "composite: {} has no plate for filmed frame {}: its plates are numbered 0 to {} from "
          "the first, and the film's frames 0 to {}; a moving camera needs a plate for each filmed "
          "frame, or {} for each, one a picture of the finished shot",
          PrintableName(plates), frame, pictures.back().frame, film_frames.back(), per_frame_));
}

const fs::path* MovingPlates::Find(int picture) const {
  if (picture % step_) return nullptr;
  const auto found = std::find_if(files_.pictures().begin(), files_.pictures().end(),
                                  [&](const FilmPicture& p) { return p.frame == picture / step_; });
  return found == files_.pictures().end() ? nullptr : &found->path;
}

ImageF MovingPlates::Read(const fs::path& path) const {
  if (scene_) return scene_->Light(path);
  ImageF picture = ReadLevels(path);
  if (picture.width != camera_.width || picture.height != camera_.height)
    throw InputError(fmt::format(
        "composite: the plate {} has {} x {} pixels, but the shot was located in pictures of {} x "
        "{}; all pictures of a shot must have one size: scale or crop none of them",
        PrintableName(path), picture.width, picture.height, camera_.width, camera_.height));
  return picture;
}

MovingPlate MovingPlates::At(int animation) {
  const int picture = animation + start_;
  if (const fs::path* own = Find(picture)) return {Read(*own)};
  int before = picture - 1, after = picture + 1;
  const int last = files_.pictures().back().frame * step_;
  while (before > 0 && !Find(before)) --before;
  while (after < last && !Find(after)) ++after;
  const fs::path *first = Find(before), *second = Find(after);
  if (!first || !second) return {Read(*(first ? first : second))};
  const double share = 1.0 * (picture - before) / (after - before);
  PlateBetweenTwo between = PlateBetween(Read(*first), Read(*second), share);
  ++made;
  doubtful = std::max(doubtful, between.doubtful);
  const double kept = share * share + (1 - share) * (1 - share);
  return {std::move(between.picture), static_cast<float>(1 - kept), between.doubtful};
}

}  // namespace keypose::composite
