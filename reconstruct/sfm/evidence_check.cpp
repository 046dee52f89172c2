#include "reconstruct/sfm/evidence_check.h"

#include <algorithm>
#include <iterator>
#include <nlohmann/json.hpp>

#include "core/io/image_io.h"
#include "core/io/image_set.h"
#include "core/parallel.h"
#include "core/size_of.h"
#include "core/tuned.h"

namespace keypose::reconstruct {
namespace {

/// Values with which the overlaps of docs/decisions/one-evidence-for-all-cameras.md were measured;
/// no record that others were tried. Sensitivity: docs/results/sensitivity.md.
struct EvidenceCheckTuning {
  KEYPOSE_TUNED(double, kSide_px, 500);  ///< longer side to which masks are reduced
  /// of matches from their epipolar lines, as in verification
  KEYPOSE_TUNED(double, kMaxError_px, 4);
};

double ShrinkFactor(int width, int height) {
  return std::min(1.0, EvidenceCheckTuning::kSide_px / std::max(width, height));
}

std::vector<Image8> SmallMasks(const ImageSet& set) {
  std::vector<Image8> masks(set.images.size());
  ParallelFor(std::ssize(masks), [&](std::int64_t i) {
    const CapturedImage& image = set.images[i];
    if (image.mask.empty()) return;
    Camera size;
    size.width = image.width, size.height = image.height;
    size = size.Scaled(ShrinkFactor(image.width, image.height));
    masks[i] = Resized(ReadImage(set.MaskPath(static_cast<int>(i)), 1), size.width, size.height);
  });
  return masks;
}

std::vector<PreparedView> ViewsOf(const ImageSet& set, const std::vector<Image8>& masks,
                                  const Scene& scene) {
  std::vector<PreparedView> views(scene.views.size());
  ParallelFor(std::ssize(views), [&](std::int64_t v) {
    View view = scene.views[v];
    const int i = set.Find(view.name);
    if (i < 0 || masks[i].empty()) return;
    view.camera = view.camera.Scaled(ShrinkFactor(view.camera.width, view.camera.height));
    // The hull needs no colour.
    const Image8 grey(view.camera.width, view.camera.height, 3, 128);
    views[v] = PrepareView(view, static_cast<int>(v), grey, masks[i], 1, 1);
  });
  std::erase_if(views, [](const PreparedView& view) { return view.masked_pixels == 0; });
  return views;
}

}  // namespace

std::vector<PreparedView> MaskViews(const ImageSet& set, const Scene& scene) {
  return ViewsOf(set, SmallMasks(set), scene);
}

EvidenceCheck::EvidenceCheck(const ImageSet& set) : set_(set), masks_(SmallMasks(set)) {}

CameraEvidence EvidenceCheck::Evaluate(const Scene& scene, const std::vector<Features>& features,
                                       const std::vector<PairMatches>& verified) const {
  CameraEvidence evidence;
  evidence.images = SizeOf(set_.images);
  evidence.placed = SizeOf(scene.views);
  if (evidence.placed < 3) return evidence;
  const std::vector<PreparedView> views = ViewsOf(set_, masks_, scene);
  if (views.size() < 3) return evidence;
  const auto hull = MeasureOutlines(views, evidence);
  if (!hull) return evidence;
  std::vector<int> view_of_image(set_.images.size(), -1);
  for (std::size_t v = 0; v < scene.views.size(); ++v)
    if (const int i = set_.Find(scene.views[v].name); i >= 0)
      view_of_image[i] = static_cast<int>(v);
  CountAgreeingPairs(scene, view_of_image, features, verified, *hull,
                     EvidenceCheckTuning::kMaxError_px, evidence);
  return evidence;
}

void ReportEvidence(StageContext& stage, const CameraEvidence& evidence) {
  stage.Report("hull_iou_mean", evidence.hull_iou);
  stage.Report("hull_iou_least", evidence.hull_iou_least);
  if (evidence.holes_filled) stage.Report("mask_holes_filled", 1);
  stage.ReportJson("views_disagreeing", nlohmann::json(evidence.disagreeing).dump());
  stage.Report("pairs_tied", evidence.pairs);
  stage.Report("pairs_agreeing", evidence.pairs_agree);
  if (evidence.disagreeing.empty()) return;
  std::string names;
  for (const std::string& name : evidence.disagreeing) names += (names.empty() ? "" : ", ") + name;
  // Only a note: these masks have not been compared with each other yet, and most such views are
  // correct. `masks` compares them, and warns.
  stage.Note("the outlines of these photographs do not fit the other ones: " + names +
             "; look at their masks (contact_sheet.jpg), and whether they were cropped, turned, or "
             "shot with another zoom");
}

}  // namespace keypose::reconstruct
