// Sound that an animation is timed to: WAV, FLAC, MP3, Opus and what else libav decodes.
#pragma once

#include <filesystem>

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

}  // namespace keypose
