// Last part of sfm: matches points by grey values, and adjusts the cameras to them.
#pragma once

#include "core/stage/stage.h"
#include "reconstruct/sfm/posed_model.h"

namespace keypose {
struct ImageSet;
}

namespace keypose::reconstruct {

/// Two rounds of patch tracks and adjustment. The cameras of a turntable are constrained to its
/// rings unless the data contradict that; calibration boards keep fixing the frame. A photograph
/// with too few patches keeps its features. If the result is no better, the model is returned
/// unchanged. Reports patch_points, patch_observations, patch_error_px, turntable_chi2_ratio,
/// on_turntable.
/// @param model  adjusted; with the observations of its points
/// @param matched  the features that the model was made of: of whole photographs, patches are
/// tracked all over the pictures too
Scene RefineByPatches(StageContext& stage, const ImageSet& set, const PosedModel& model,
                      const MatchedFeatures& matched, const SfmOptions& options);

/// Sets the colours of points of our own models, each from the first photograph that shows it.
void ColorPoints(const ImageSet& set, Scene& scene);

}  // namespace keypose::reconstruct
