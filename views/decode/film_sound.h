// The sound of a film, as loud as it is in each millisecond.
#pragma once

#include <filesystem>
#include <vector>

#include "core/values/progress.h"
#include "views/decode/film_index.h"

namespace keypose {

struct FilmSound {
  double first_s = 0;            ///< begin of the first millisecond, by the clock of FilmIndex
  std::vector<float> per_milli;  ///< mean square of all channels' samples, which lie in [-1, 1]
};

/// Decodes the first sound of a film. What cannot be decoded counts as no sound, and so do samples
/// that are no numbers.
/// @param index     of this file
/// @param most_s    what comes later than so long after the first sample is not read
/// @param progress  asked for cancel; may be null
/// @return empty if it has none
FilmSound ReadFilmSound(const std::filesystem::path& path, const FilmIndex& index, double most_s,
                        const Progress* progress = nullptr);

}  // namespace keypose
