// `keypose synth score-video`: a textured performance compared with the film of a camera that it
// was not made from.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/values/image.h"

namespace keypose::synth {

struct VideoScoreCommand {
  std::filesystem::path performance;  ///< folder that `synth performance` wrote
  std::filesystem::path frames;       ///< frame_0000.ply ... of the moving mesh
  std::filesystem::path textures;     ///< frame_0000.png ... or .jpg of `video3d`
  std::filesystem::path layout;       ///< mesh with UVs; empty: the first frame has them
  std::filesystem::path picture;      ///< .jpg to write: film, render, difference; empty: none
  int every = 1;                      ///< only every n-th frame
};

/// Sums over pixels of one or more pictures.
struct VideoErrors {
  double squares = 0, values = 0;          ///< inside the outline, where the mesh covers too
  double rim_squares = 0, rim_values = 0;  ///< of these, within kRimPixels of the outline
  double halo = 0, halo_scale = 0;         ///< differences along the way to the background's colour
  double covered = 0, inside = 0;  ///< pixels inside the outline; those that the mesh covers
  void Add(const VideoErrors& other);
};
inline constexpr int kRimPixels = 5;

/// @param film     RGB
/// @param render   RGBA, of the same size
/// @param outline  1 channel: over 127 where the actor is. Pixels that touch its border are left
/// out, because the film mixes actor and background there
VideoErrors ComparePictures(const Image8& film, const Image8& render, const Image8& outline);

struct VideoScore {
  int frames = 0;
  double psnr_db = 0;      ///< over all pixels of all frames
  double rim_psnr_db = 0;  ///< of the rim
  /// how far colours at the rim lean to the background's: 0 not at all, 1: they are the background
  double rim_halo = 0;
  double covered = 0;  ///< share of the actor that the mesh covers
  std::vector<double> frame_psnr_db;
};

/// @throws InputError  files missing, or of another performance
VideoScore ScoreVideo(const VideoScoreCommand& command);
/// As JSON.
std::string ToJson(const VideoScore& score);

}  // namespace keypose::synth
