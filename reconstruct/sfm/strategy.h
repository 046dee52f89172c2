// What all strategies of sfm share: what they work on, what each gives back, and which result is
// taken.
#pragma once

#include <string>
#include <vector>

#include "reconstruct/sfm/evidence_check.h"
#include "reconstruct/sfm/matched_features.h"
#include "reconstruct/sfm/measurements.h"
#include "reconstruct/sfm/posed_model.h"

namespace keypose::reconstruct {

/// Cameras, the strategy that found them, what speaks for them, and what was measured on the way: a
/// result that is not taken leaves nothing in the report.
struct StrategyResult {
  PosedModel model = {};  ///< adjusted
  std::string method = {};
  CameraEvidence evidence = {};
  Measurements measurements = {};
  std::size_t views() const { return model.scene.views.size(); }
};

/// What all strategies work on. They use the stage for its progress, its tools and its log; they
/// report nothing but the time that they cost.
struct StrategyContext {
  StageContext& stage;
  const ImageSet& set;
  const SfmOptions& options;
  const EvidenceJudge& judge;
  Stopwatch& watch;

  /// The same cameras with their evidence. Of many views some are asked, which is quick.
  StrategyResult Judged(StrategyResult result, const MatchedFeatures& matched) const;
  /// Whether all photographs have a camera that the evidence leaves no doubt about.
  bool IsSettled(const StrategyResult& result) const;
};

/// The candidate where the evidence prefers it, else the best so far.
StrategyResult BetterOf(StrategyResult best, StrategyResult candidate);

/// Focal lengths worth trying, in pixels, the likeliest first: that which the photographs tell,
/// else those of lenses from 26 to 92 mm (as of 35 mm film) in steps of a fifth.
std::vector<double> FocalsToTry(const MatchedFeatures& matched);

/// The camera with another focal length.
Camera WithFocal(Camera camera, double focal_px);

}  // namespace keypose::reconstruct
