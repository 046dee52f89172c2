#include "reconstruct/sfm/evidence_check.h"

#include <algorithm>
#include <iterator>
#include <nlohmann/json.hpp>

#include "core/io/pictures/image_io.h"
#include "core/io/pictures/image_set.h"
#include "core/numbers/parallel.h"
#include "core/values/size_of.h"
#include "core/values/tuned.h"

namespace keypose::reconstruct {
namespace {

/// Values with which the overlaps of docs/algorithms/sfm.md were measured;
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
    size.width = image.width;
    size.height = image.height;
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
  CountAgreeingPairs(scene, ViewOfImage(scene), features, verified, *hull,
                     EvidenceCheckTuning::kMaxError_px, evidence);
  return evidence;
}

std::vector<int> EvidenceCheck::ViewOfImage(const Scene& scene) const {
  std::vector<int> view_of_image(set_.images.size(), -1);
  for (std::size_t v = 0; v < scene.views.size(); ++v)
    if (const int i = set_.Find(scene.views[v].name); i >= 0)
      view_of_image[i] = static_cast<int>(v);
  return view_of_image;
}

CameraEvidence EvidenceCheck::EvaluateSurroundings(const Scene& scene,
                                                   const std::vector<Features>& features,
                                                   const std::vector<PairMatches>& verified) const {
  CameraEvidence evidence = Evaluate(scene, {}, {});
  evidence.by_surroundings = true;
  const std::vector<char> agrees = Agreement(scene, features, verified);
  evidence.pairs =
      static_cast<int>(std::count_if(agrees.begin(), agrees.end(), [](char a) { return a >= 0; }));
  evidence.pairs_agree = static_cast<int>(std::count(agrees.begin(), agrees.end(), 1));
  return evidence;
}

std::vector<char> EvidenceCheck::Agreement(const Scene& scene,
                                           const std::vector<Features>& features,
                                           const std::vector<PairMatches>& verified) const {
  return AgreementOfPairs(scene, ViewOfImage(scene), features, verified,
                          EvidenceCheckTuning::kMaxError_px);
}

Scene EvidenceCheck::WithoutContradicted(const Scene& scene, const std::vector<Features>& features,
                                         const std::vector<PairMatches>& verified) const {
  const std::vector<int> view_of_image = ViewOfImage(scene);
  const std::vector<char> agrees =
      AgreementOfPairs(scene, view_of_image, features, verified, EvidenceCheckTuning::kMaxError_px);
  std::vector<int> for_it(scene.views.size(), 0), against(scene.views.size(), 0);
  for (std::size_t k = 0; k < verified.size(); ++k) {
    if (agrees[k] < 0) continue;
    for (const int image : {verified[k].first, verified[k].second})
      ++(agrees[k] ? for_it : against)[static_cast<std::size_t>(view_of_image[image])];
  }
  Scene right;
  std::vector<int> index(scene.views.size(), -1);
  for (std::size_t v = 0; v < scene.views.size(); ++v) {
    if (against[v] > for_it[v]) continue;
    index[v] = static_cast<int>(right.views.size());
    right.views.push_back(scene.views[v]);
  }
  for (const SparsePoint& point : scene.points) {
    SparsePoint kept = point;
    kept.views.clear();
    for (const int v : point.views)
      if (index[static_cast<std::size_t>(v)] >= 0)
        kept.views.push_back(index[static_cast<std::size_t>(v)]);
    if (kept.views.size() >= 2) right.points.push_back(std::move(kept));
  }
  return right;
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
             "; look at their masks (contact_sheet.jpg; in a project out/POSE/masks.jpg), and "
             "whether they were cropped, turned, or "
             "shot with another zoom");
}

}  // namespace keypose::reconstruct
