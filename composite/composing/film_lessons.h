// Learns from filmed frames.
#pragma once

#include "composite/composing/lessons.h"
#include "core/progress.h"

namespace keypose::composite {

/// @param along  rays along each side of a pixel
/// @throws InputError  the character is outside of the picture in all filmed frames
/// Same bits for any thread count.
FilmLessons LearnFromFilm(const ShotGeometry& geometry, const Looks& looks, const Film& film,
                          int along, Progress* progress);

}  // namespace keypose::composite
