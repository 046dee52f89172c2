// Types that all strategies of sfm share: their input, their result, and the comparison of results.
#pragma once

#include <string>
#include <vector>

#include "reconstruct/sfm/evidence_check.h"
#include "reconstruct/sfm/matched_features.h"
#include "reconstruct/sfm/measurements.h"
#include "reconstruct/sfm/posed_model.h"

namespace keypose::reconstruct {

/// Cameras, the strategy that found them, their evidence, and measurements. The measurements of a
/// result that is not used are not reported.
struct StrategyResult {
  PosedModel model = {};  ///< adjusted
  std::string method = {};
  CameraEvidence evidence = {};
  Measurements measurements = {};
  std::size_t views() const { return model.scene.views.size(); }
};

/// The input of all strategies. They use the stage for progress, tools and the log, and report
/// nothing but their time.
struct StrategyContext {
  StageContext& stage;
  const ImageSet& set;
  const SfmOptions& options;
  const EvidenceCheck& check;
  Stopwatch& watch;

  /// The same cameras with their evidence. For speed only some of many views are checked.
  StrategyResult WithEvidence(StrategyResult result, const MatchedFeatures& matched) const;
  /// Whether all photographs have a camera and the evidence is sure.
  bool IsSettled(const StrategyResult& result) const;
};

/// The candidate if the evidence prefers it, else the best so far.
StrategyResult BetterOf(StrategyResult best, StrategyResult candidate);

/// Focal lengths to try, in pixels, the most likely first: the one from the EXIF data, else those
/// of lenses from 26 to 92 mm (35 mm equivalent) in steps of a fifth.
std::vector<double> FocalsToTry(const MatchedFeatures& matched);

/// The camera with another focal length.
Camera WithFocal(Camera camera, double focal_px);
/// The cameras with focal lengths scaled so that the first one has this.
std::vector<Camera> WithFocal(std::vector<Camera> cameras, double focal_px);

}  // namespace keypose::reconstruct
