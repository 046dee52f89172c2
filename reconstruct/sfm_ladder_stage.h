// Second half of sfm: cameras from what the photographs show, by one strategy after the other until the evidence leaves no doubt.
#pragma once

#include <filesystem>
#include <string>

#include "reconstruct/placed_stage.h"
#include "reconstruct/sfm_hull_check_stage.h"
#include "reconstruct/sfm_matching_stage.h"

namespace keypose::reconstruct {

/// Cameras, the strategy that found them, and what speaks for them.
struct Placed {
  PlacedModel model;  ///< adjusted
  std::string method;
  CameraEvidence evidence;
  std::size_t views() const { return model.scene.views.size(); }
};

/// What all strategies work on.
struct Ladder {
  StageContext& stage;
  const ImageSet& set;
  const SfmOptions& options;
  const EvidenceJudge& judge;
  Stopwatch& watch;

  /// The same cameras with their evidence. Of many views some are asked, which is quick.
  Placed Judged(Placed placed, const Seen& seen) const;
  /// Whether all photographs have a camera that the evidence leaves no doubt about.
  bool IsSettled(const Placed& placed) const;
};

/// Down the ladder until a rung holds all photographs and the evidence is sure; else the rung for which the evidence is best. Coarse
/// features come first, and fine ones where those leave photographs out, hang on few points, or give doubtful cameras.
/// @param seen  set: what the photographs showed in the end
/// @throws InputError  the photographs share so little that no strategy can succeed; said before any is tried
Placed Place(const Ladder& ladder, const std::filesystem::path& scratch, Seen& seen);

}  // namespace keypose::reconstruct
