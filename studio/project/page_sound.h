// The sound that the animation is timed to: a file of the project, named in pipeline.yaml.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "studio/project/snapshot.h"

namespace keypose::studio {

/// {"file": "sound/line.wav", "name": "line.wav", "at": 0.5}, at [s] on the timeline; null: none.
nlohmann::json SoundToPage(Snapshot& snapshot);

/// Where the project's sound lies. @throws UsageError  it has none
std::filesystem::path SoundFileOf(const Snapshot& snapshot);

/// Puts a sound into the project's folder sound/ and names it in pipeline.yaml, at the timeline's
/// begin. A file of that name with other content stays, and the new one gets a number.
/// @throws UsageError  no name of a file
/// @throws InputError  nothing that films can carry  @throws ChangedMeanwhile
void PutSound(Snapshot& snapshot, const std::string& name, const std::string& bytes);

/// When it begins [s] on the timeline, in the film and in a filmed shot.
/// @throws ChangedMeanwhile, InputError
void MoveSound(Snapshot& snapshot, double at_s);

/// The project names no sound any more; the file stays. @throws ChangedMeanwhile
void RemoveSound(Snapshot& snapshot);

}  // namespace keypose::studio
