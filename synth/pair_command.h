// `keypose synth pair`: writes a registration problem with its exact answer.
#pragma once

#include <filesystem>

#include "synth/clay_pair.h"

namespace keypose::synth {

struct PairCommand {
  std::filesystem::path output;
  ClayPairOptions pair;
};

/// Writes into `output`:
///
///     source.ply, target.ply
///     truth.ply              the source's faces, its vertices at their exact place in the target's
///     pose source_landmarks.json, target_landmarks.json    the picks, joined by name; left out
///     when there are none landmarks.txt          the same as lines `source_vertex target_vertex`,
///     for programs that only take vertices world.json             the options, sizes, and the
///     named places
///
/// @return one line that says what was written
/// @throws as MakeClayPair, and DiskError
std::string RunPair(const PairCommand& command);

}  // namespace keypose::synth
