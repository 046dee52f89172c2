// Which pictures a finished shot has: filmed frames as they are, and in-betweens at times between.
#pragma once

#include <string>
#include <vector>

#include "core/values/filmed_shot.h"

namespace keypose::composite {

/// What the animation's frames say of themselves.
struct AnimationTimes {
  double fps = 24;
  int frame_count = 0;
  std::vector<int> key_frames;  ///< the frame of each key; may be empty
  std::vector<double> t;  ///< per frame: key number plus share of the way to the next, or empty
};

enum class PictureKind {
  kFilmed,   ///< a filmed frame, unchanged
  kBetween,  ///< the character is rendered
  kHeld      ///< outside of the animation: the filmed frame before stands
};

struct PlannedPicture {
  PictureKind kind = PictureKind::kBetween;
  int filmed = -1;     ///< index into the film's pictures: itself, or the one that stands
  int animation = -1;  ///< frame of the animation; -1: none
};

struct FilmPlan {
  std::vector<PlannedPicture> pictures;   ///< at the animation's rate, from the film's first frame
  int per_frame = 2;                      ///< pictures a filmed frame
  int start = 0;                          ///< the picture that shows the animation's frame 0
  int first_frame = 0;                    ///< the film's frame in which that is
  int filmed = 0, between = 0, held = 0;  ///< counts
};

/// The animation's first frame is at the shot's first keyed frame.
///
/// @param film_frames  numbers of the filmed frames, ascending from 0; empty: nothing was filmed,
///                     and every frame of the animation is rendered
/// @throws InputError  the animation's rate is no multiple of the film's; no frame of the shot
/// shows
///                     a pose; the shot's keyed frames are not where the animation has its keys
FilmPlan PlanFilm(const FilmedShot& shot, const std::vector<int>& film_frames,
                  const AnimationTimes& animation);

}  // namespace keypose::composite
