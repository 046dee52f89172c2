#include "composite/plan/film_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose::composite {
namespace {

/// 23.976 is typed for 24000 / 1001, which a video says; 24 is another rate.
constexpr double kSameRate = 1e-4;

int PicturesPerFrame(double film_fps, double animation_fps) {
  const double ratio = animation_fps / film_fps;
  const int whole = static_cast<int>(std::lround(ratio));
  if (whole < 1 || std::abs(ratio - whole) > kSameRate * whole)
    throw InputError(fmt::format(
        "composite: the animation has {:g} frames a second and the film {:g}; the first must be a "
        "multiple of the second, such as 24 and 12: set `fps` of the project or of its shot",
        animation_fps, film_fps));
  return whole;
}

/// Where nothing was filmed, a camera is enough: the animation begins at its first frame.
int FirstKeyedFrame(const FilmedShot& shot, bool filmed) {
  for (const ShotFrame& frame : shot.frames)
    if (!frame.pose.empty()) return frame.frame;
  if (!filmed && !shot.frames.empty()) return shot.frames.front().frame;
  throw InputError(
      "composite: no frame of the shot shows a key pose, so the animation has no place in it; say "
      "which frames show which pose when you locate them");
}

std::string Listed(const std::vector<int>& numbers) {
  std::string text;
  for (const int number : numbers) text += (text.empty() ? "" : ", ") + std::to_string(number);
  return text.empty() ? "none" : text;
}

/// A shot may use only some of the animation's keys, but each of its own must be one of them.
void RequireKeysThere(const FilmedShot& shot, const AnimationTimes& animation,
                      const FilmPlan& plan) {
  if (animation.key_frames.empty()) return;
  const std::set<int> keys(animation.key_frames.begin(), animation.key_frames.end());
  std::vector<int> wanted;
  bool all = true;
  for (const ShotFrame& frame : shot.frames)
    if (!frame.pose.empty()) {
      wanted.push_back(frame.frame * plan.per_frame - plan.start);
      all = all && keys.count(wanted.back());
    }
  if (all) return;
  throw InputError(fmt::format(
      "composite: the shot shows key poses at the animation's frames {}, but the animation has its "
      "keys at {}; give the timeline the times of the filmed frames, at {:g} frames a second",
      Listed(wanted), Listed(animation.key_frames), animation.fps));
}

}  // namespace

FilmPlan PlanFilm(const FilmedShot& shot, const std::vector<int>& film_frames,
                  const AnimationTimes& animation) {
  FilmPlan plan;
  plan.per_frame = PicturesPerFrame(shot.fps, animation.fps);
  plan.first_frame = FirstKeyedFrame(shot, !film_frames.empty());
  plan.start = plan.first_frame * plan.per_frame;
  RequireKeysThere(shot, animation, plan);
  const int last_filmed = film_frames.empty() ? 0 : film_frames.back() * plan.per_frame;
  const int count = std::max(last_filmed, plan.start + animation.frame_count - 1) + 1;
  int before = -1;
  for (int n = film_frames.empty() ? plan.start : 0; n < count; ++n) {
    PlannedPicture picture;
    const auto filmed = n % plan.per_frame
                            ? film_frames.end()
                            : std::find(film_frames.begin(), film_frames.end(), n / plan.per_frame);
    const int shown = n - plan.start;
    if (shown >= 0 && shown < animation.frame_count) picture.animation = shown;
    if (filmed != film_frames.end()) {
      before = static_cast<int>(filmed - film_frames.begin());
      picture.kind = PictureKind::kFilmed;
      picture.filmed = before;
      ++plan.filmed;
    } else if (picture.animation >= 0) {
      ++plan.between;
    } else {
      picture.kind = PictureKind::kHeld;
      picture.filmed = before;
      ++plan.held;
    }
    plan.pictures.push_back(picture);
  }
  if (film_frames.empty()) plan.start = 0;
  return plan;
}

}  // namespace keypose::composite
