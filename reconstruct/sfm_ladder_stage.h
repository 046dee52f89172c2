// Second half of sfm: cameras from what the photographs show, down a ladder of methods.
#pragma once

#include <filesystem>
#include <string>

#include "reconstruct/placed_stage.h"
#include "reconstruct/sfm_matching_stage.h"

namespace keypose::reconstruct {

/// Cameras and the method that found them.
struct Placed {
  PlacedModel model;  ///< adjusted
  std::string method;
  std::size_t views() const { return model.scene.views.size(); }
};

/// Down the ladder until a rung holds all photographs; else the rung that holds most. Coarse features come first, and fine ones where those
/// leave photographs out or hang on few points.
/// @param focal_known  set: whether the photographs told the focal length
Placed Place(StageContext& stage, const ImageSet& set, const std::filesystem::path& scratch, const SfmOptions& options, Stopwatch& watch,
             bool& focal_known);

}  // namespace keypose::reconstruct
