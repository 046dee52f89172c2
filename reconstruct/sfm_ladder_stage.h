// Second half of sfm: cameras from what the photographs show, down a ladder of methods.
#pragma once

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

/// Down the ladder until a rung holds all photographs; else the rung that holds most.
Placed Place(StageContext& stage, const ImageSet& set, const SfmFiles& files, const SfmOptions& options, const Seen& seen,
             Stopwatch& watch);

}  // namespace keypose::reconstruct
