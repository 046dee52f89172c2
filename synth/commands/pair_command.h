// `keypose synth pair`: writes a registration problem with its exact solution.
#pragma once

#include <filesystem>

#include "synth/worlds/clay_pair.h"

namespace keypose::synth {

struct PairCommand {
  std::filesystem::path output;
  ClayPairOptions pair;
};

/// Writes into `output`:
///
/// - source.ply, target.ply
/// - truth.ply: the source's faces, with its vertices at their exact position in the target's pose
/// - source_landmarks.json, target_landmarks.json: the picks, joined by name; only if there are any
/// - landmarks.txt: the same as lines `source_vertex target_vertex`, for programs that only take
///   vertices
/// - world.json: the options, sizes, and the named places
///
/// @return one line about the written files
/// @throws as MakeClayPair, and DiskError
std::string RunPair(const PairCommand& command);

}  // namespace keypose::synth
