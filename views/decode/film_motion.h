// How much moves in a film, from picture to picture.
#pragma once

#include <filesystem>
#include <vector>

#include "core/values/progress.h"
#include "views/decode/film_index.h"

namespace keypose {

struct FilmMotion {
  std::vector<double> times_s;  ///< midway between two pictures, by the clock of FilmIndex
  std::vector<double> values;   ///< square root of the mean change of luma, in levels a second
};

/// Decodes a film's pictures and compares each with the one before, reduced to cells. Changes of
/// the whole picture's brightness are taken out, and the change that an encoder makes where it
/// begins anew.
/// @param index     of this file
/// @param most_s    pictures later than so long after the first are not read
/// @param progress  asked for cancel before each picture; may be null
/// @return empty if it has fewer than three pictures, or stops being decoded
FilmMotion ReadFilmMotion(const std::filesystem::path& path, const FilmIndex& index, double most_s,
                          const Progress* progress = nullptr);

}  // namespace keypose
