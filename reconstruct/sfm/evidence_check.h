// Checks cameras against the outlines and the matches in the photographs.
#pragma once

#include <vector>

#include "core/stage/stage.h"
#include "core/values/camera.h"
#include "core/values/image.h"
#include "reconstruct/evidence/camera_evidence.h"
#include "views/prepared/prepared_view.h"

namespace keypose {
struct ImageSet;
}

namespace keypose::reconstruct {

/// The masks of a scene's views at about 500 px, without colour; views whose photographs have none
/// are left out.
std::vector<PreparedView> MaskViews(const ImageSet& set, const Scene& scene);

/// The evidence of one set of photographs, for comparing all strategies. Masks are read once.
class EvidenceCheck {
 public:
  explicit EvidenceCheck(const ImageSet& set);

  /// @param features, verified  of all images; may be empty
  CameraEvidence Evaluate(const Scene& scene, const std::vector<Features>& features,
                          const std::vector<PairMatches>& verified) const;
  /// The evidence for cameras that whole photographs placed. Outlines are measured, but do not
  /// count.
  CameraEvidence EvaluateSurroundings(const Scene& scene, const std::vector<Features>& features,
                                      const std::vector<PairMatches>& verified) const;
  /// By pair: AgreementOfPairs.
  std::vector<char> Agreement(const Scene& scene, const std::vector<Features>& features,
                              const std::vector<PairMatches>& verified) const;
  /// The scene without views that most of their pairs contradict: wrong ones.
  Scene WithoutContradicted(const Scene& scene, const std::vector<Features>& features,
                            const std::vector<PairMatches>& verified) const;
  /// Masks of all images at about 500 px; empty where there is none.
  const std::vector<Image8>& masks() const { return masks_; }

  /// For each image of the set the index of its view, or -1.
  std::vector<int> ViewOfImage(const Scene& scene) const;

 private:
  const ImageSet& set_;
  std::vector<Image8> masks_;
};

/// Reports hull_iou_mean, hull_iou_least, views_disagreeing, pairs_tied and pairs_agreeing, and
/// notes the views that disagree.
void ReportEvidence(StageContext& stage, const CameraEvidence& evidence);

}  // namespace keypose::reconstruct
