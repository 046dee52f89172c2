// Whether the outlines in the photographs agree with the cameras that were found.
#pragma once

#include <vector>

#include "core/camera.h"
#include "core/stage/stage.h"
#include "reconstruct/dense_view.h"

namespace keypose {
struct ImageSet;
}

namespace keypose::reconstruct {

/// The masks of a scene's views at some 500 px, without colour; views whose photographs have none are left out.
std::vector<DenseView> MaskViews(const ImageSet& set, const Scene& scene);

/// Reprojection errors stay small when the principal point is wrong or a photograph is turned; the common hull of all masks does not.
/// Reports hull_iou_mean, hull_iou_least and views_disagreeing, and notes the names; nothing where masks have no common space.
void ReportHullAgreement(StageContext& stage, const ImageSet& set, const Scene& scene);

}  // namespace keypose::reconstruct
