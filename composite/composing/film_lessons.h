// Learns from filmed frames.
#pragma once

#include "composite/composing/lessons.h"
#include "composite/light/stated_light.h"
#include "core/values/progress.h"

namespace keypose::composite {

struct LearnOptions {
  int along = 4;        ///< rays along each side of a pixel
  bool follow = false;  ///< bend the animation's frames that were filmed until they lie on the film
  StatedLight stated;   ///< where no filmed frame tells the light
};

/// @throws InputError  the character is outside of the picture in all filmed frames
/// Same bits for any thread count.
FilmLessons LearnFromFilm(const ShotGeometry& geometry, const Looks& looks, const Film& film,
                          const LearnOptions& options, Progress* progress);

}  // namespace keypose::composite
