// `keypose synth pick` and `keypose synth score`: a reconstruction, compared with its truth.
#pragma once

#include <filesystem>
#include <string>

namespace keypose::synth {

struct PickCommand {
  std::filesystem::path truth, model, mesh, output;
  double reach = 0.03;
};
/// Writes the landmarks that an artist would click. @return a line for the console
/// @throws InputError  fewer than 3 landmarks are on the mesh
std::string RunPick(const PickCommand& command);

struct ScoreCommand {
  std::filesystem::path truth, model, mesh;                                         ///< one pose
  std::filesystem::path template_truth, template_model, template_mesh, registered;  ///< correspondence; empty: not scored
};
/// @return JSON: cameras, surface (after the cameras' alignment), surface_refined (after ICP), closed, correspondence,
/// correspondence_refined
std::string RunScore(const ScoreCommand& command);

}  // namespace keypose::synth
