// Last part of sfm: points found again by grey values, and cameras adjusted to them.
#pragma once

#include "core/stage/stage.h"
#include "reconstruct/sfm/posed_model.h"

namespace keypose {
struct ImageSet;
}

namespace keypose::reconstruct {

/// Two rounds of patches and adjustment. The cameras of a turntable are held to its rings where the
/// data do not speak against it; plates stay what fixes the frame. A photograph in which too few
/// patches are found keeps its features. The model comes back as it was where that gives no better
/// one. Reports patch_points, patch_observations, patch_error_px, turntable_chi2_ratio,
/// on_turntable.
/// @param model  adjusted; with the observations of its points
Scene RefineByPatches(StageContext& stage, const ImageSet& set, const PosedModel& model,
                      bool focal_known, const SfmOptions& options);

/// Colours of points that a model of ours has, each from the first photograph that shows it.
void ColorPoints(const ImageSet& set, Scene& scene);

}  // namespace keypose::reconstruct
