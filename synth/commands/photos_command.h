// `keypose synth photos`: renders a world's photographs and writes them with their truth.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "core/values/progress.h"
#include "synth/photographs/photographer.h"
#include "synth/worlds/world.h"

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
  /// Poses of which only so many photographs are taken, spread over the rig's rings. The rig is
  /// that of the first pose with all photographs; of `rest` when there is none.
  std::map<std::string, int> few;
  int jpeg_quality = 94;

  /// One sentence per fault; empty when valid.
  std::vector<std::string> Problems() const;
};

/// Reads texts such as "wave=6".
/// @throws UsageError  another form
std::map<std::string, int> ReadFew(const std::vector<std::string>& texts);

/// Which of the rig's views `count` photographs are taken from: as many from each ring, at even
/// angles, and those of different rings between each other. Ascending.
std::vector<int> SpreadOverRings(const PhotographerOptions& rig, int count);

/// Writes photos/POSE/*.jpg, truth/POSE/ and, if asked, background/POSE.jpg below `output`.
/// @throws UsageError  a fault in the command, or an unknown pose @throws DiskError
/// @return number of photographs written
int RunPhotos(const PhotosCommand& command, Progress* progress);

}  // namespace keypose::synth
