// Sound that an animation is timed to: WAV, FLAC, MP3, Opus and what else libav decodes.
#pragma once

#include <filesystem>
#include <string>

#include "core/values/progress.h"
#include "views/film/sound.h"

namespace keypose {

/// Longer sounds are refused.
inline constexpr double kLongestSound_s = 1800;

/// The first sound of a sound file or film, as two channels: of one both are the same, of more they
/// are mixed down. It begins with the file's first sample; that of a film with its first picture.
/// Where a container leaves a gap, there is silence.
/// @param progress  asked for cancel; may be null
/// @throws InputError  no sound, no decoder for it, damaged, longer than kLongestSound_s
/// @throws DiskError   there is no such file
Sound ReadSound(const std::filesystem::path& path, const Progress* progress = nullptr);

/// What is heard in a film.
struct HeardSound {
  Sound sound;          ///< from the film's first picture on
  std::string warning;  ///< that nothing is heard, and why; else empty
};

/// The sound of a file where it begins at this time of a film.
/// @param at_s    below 0: so much of its beginning is left out
/// @param film_s  how long the film lasts
/// @throws InputError, DiskError  as ReadSound
HeardSound ReadSoundAt(const std::filesystem::path& path, double at_s, double film_s,
                       const Progress* progress = nullptr);

}  // namespace keypose
