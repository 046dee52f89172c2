// `keypose synth photos`: renders a world's photographs and writes them with their truth.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/progress.h"
#include "synth/photographer.h"
#include "synth/world.h"

namespace keypose::synth {

struct PhotosCommand {
  std::filesystem::path output;
  std::vector<std::string> poses = {"rest", "bent"};
  WorldOptions world;
  PhotographerOptions photographer;
  bool clean_plate = false;  ///< also write background/POSE.jpg
  /// also the same number of photographs of the character on its back, LYING_0001.jpg, ..., with
  /// cameras in the same frame
  bool flip = false;
  int jpeg_quality = 94;
};

/// Writes photos/POSE/*.jpg, truth/POSE/ and, if asked, background/POSE.jpg below `output`.
/// @return number of photographs written
int RunPhotos(const PhotosCommand& command, Progress* progress);

}  // namespace keypose::synth
