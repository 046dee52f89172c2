// `keypose synth pick` and `keypose synth score`: compare a reconstruction with its truth.
#pragma once

#include <filesystem>
#include <string>

namespace keypose::synth {

struct PickCommand {
  std::filesystem::path truth, model, mesh, output;
  double reach = 0.03;
};
/// Writes the landmarks that an artist would click.
/// @return a line for the console
/// @throws InputError  fewer than 3 landmarks are on the mesh
std::string RunPick(const PickCommand& command);

struct ScoreCommand {
  std::filesystem::path truth, model, mesh;  ///< of one pose
  /// in the model's frame; in the truth's frame; empty: not scored
  std::filesystem::path cloud, hull;
  /// correspondence; empty: not scored
  std::filesystem::path template_truth, template_model, template_mesh, registered;
  std::filesystem::path texture{},
      template_texture{};  ///< of the registered template and of the template; empty: not scored
};
/// @return JSON: cameras, surface (after alignment by the cameras), surface_refined (after ICP),
/// closed, detail (if prints move the surface), points (of the cloud), hull (against the visual
/// hull), correspondence, correspondence_refined, texels (one layout in both poses)
std::string RunScore(const ScoreCommand& command);

struct HullCommand {
  std::filesystem::path truth, output;
  double spacing_m = 0.001;
};
/// Writes the visual hull of the true masks and cameras, in the truth's frame. @return a line for
/// the console
std::string RunHull(const HullCommand& command);

}  // namespace keypose::synth
