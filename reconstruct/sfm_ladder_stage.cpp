#include "reconstruct/sfm_ladder_stage.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>

#include "core/io/colmap_io.h"
#include "core/io/image_io.h"
#include "core/io/image_set.h"
#include "core/parallel.h"
#include "reconstruct/ring_order.h"
#include "reconstruct/ring_sfm.h"
#include "reconstruct/ring_silhouettes.h"
#include "reconstruct/sfm_refine_stage.h"
#include "reconstruct/sfm_thin.h"

namespace keypose::reconstruct {
namespace fs = std::filesystem;
using nlohmann::json;

namespace {

/// The model adjusted once more, with a robust loss; known poses stay, and so does what shows neither points nor a plate.
PlacedModel Refined(StageContext& stage, PlacedModel model, const SfmOptions& options) {
  if (model.fixed || (model.observations.empty() && model.bodies.observations.empty())) return model;
  const PointSet some = SpreadPoints(model.scene, model.observations, options.adjusted_points);
  BundleResult result = AdjustBundle(some.scene, some.observations, BundleFor(model, options), stage.progress(), model.bodies);
  stage.Report("colmap_reprojection_error_px", result.before_px);
  stage.Report("refined_reprojection_error_px", result.after_px);
  stage.Report("observations_dropped", result.dropped);
  if (!model.bodies.observations.empty()) stage.Report("board_rms_px", result.bodies_rms_px);
  model.scene = std::move(result.scene);
  model.observations = std::move(result.kept);
  model.bodies = std::move(result.bodies);
  return model;
}

Placed PlaceKnown(StageContext& stage, PlacedModel model, const std::string& method, const SfmOptions& options) {
  Step(stage.progress(), 0.85, "bundle adjustment");
  return {Refined(stage, std::move(model), options), method};
}

/// Without observations of its own.
PlacedModel ModelOf(Scene scene) {
  PlacedModel model;
  model.scene = std::move(scene);
  return model;
}

Placed PlaceByFeatures(StageContext& stage, const ImageSet& set, const SfmFiles& files, const SfmOptions& options, const Seen& seen,
                       const SetBoards& boards) {
  Step(stage.progress(), 0.7, "mapping");
  const auto models = MapImages(stage, files, options);
  Placed placed{{}, "features"};
  json sizes = json::array();
  for (const fs::path& model : models) sizes.push_back(ReadColmapModel(model).views.size());
  stage.ReportJson("model_sizes", sizes.dump());
  if (models.empty()) return placed;
  PlacedModel model = ModelFromMapper(stage, set, files, {seen.features, seen.matches}, models, boards, options);
  if (model.scene.views.size() < 3) return {ModelOf(std::move(model.scene)), "features"};
  return PlaceKnown(stage, std::move(model), "features", options);
}

void ReportRing(StageContext& stage, const RingSfmResult& ring) {
  stage.Report("ring_layout", ring.layout.reason);
  stage.Report("ring_matches", ring.start.matches);
  stage.Report("ring_inliers", ring.start.inliers);
  stage.Report("ring_inlier_share", ring.start.inlier_share);
  if (!ring.found) return;
  stage.Report("ring_error_px", ring.ring_error_px);
  stage.Report("ring_free_chi2_ratio", ring.chi2_ratio);
  stage.Report("ring_freed", ring.freed);
  stage.ReportJson("ring_slop_deg", json(ring.slop_deg).dump());
  stage.ReportJson("placed_by_step_only", json(ring.by_step_only).dump());
}

/// The order in which the photographs stand on their rings, by what they show: where names do not tell it.
std::optional<RingLayout> SortedLayout(StageContext& stage, const ImageSet& set, const SfmFiles& files, const SfmOptions& options,
                                       const Seen& seen, const Scene& known) {
  if (options.rings != "auto") return std::nullopt;
  Scene part = known;
  if (part.views.empty() && options.method == "ring")
    if (const auto models = MapImages(stage, files, options); !models.empty()) part = ReadColmapModel(models[0]);
  const std::vector<std::string> names = NamesOf(set);
  const auto order = OrderOnRings(part, names, PointsOf(seen.matches, seen.features));
  if (!order) return std::nullopt;
  json rings = json::array();
  for (const auto& ring : order->layout.rings) {
    json in_order = json::array();
    for (const RingLayout::Place& place : ring) in_order.push_back(names[static_cast<std::size_t>(place.image)]);
    rings.push_back(std::move(in_order));
  }
  stage.ReportJson("order_found", rings.dump());
  stage.Warn("the names of the photographs do not tell in which order they were shot; sorted " + std::to_string(order->sorted) +
             " of " + std::to_string(names.size()) + " by what they show: " + order->layout.reason);
  return order->layout;
}

Placed PlaceByRing(StageContext& stage, const ImageSet& set, const SfmOptions& options, const Seen& seen,
                   const std::vector<RingLayout>& layouts) {
  const std::vector<std::string> names = NamesOf(set);
  RingSfmOptions ring;
  ring.matching.max_ratio = options.max_ratio;
  ring.bundle.refine_principal_point = options.refine_principal_point;
  ring.bundle.refine_distortion = options.refine_distortion;
  if (!seen.focal_known) ring.ring.focal_prior = 0.15;
  SubProgress part(stage.progress(), 0.88, 0.97);
  RingSfmResult result = ReconstructRing(seen.camera, names, seen.features, seen.matches, layouts, ring, &part);
  ReportRing(stage, result);
  if (!result.found) return {{}, "ring"};
  ColorPoints(set, result.scene);
  return {ModelOf(std::move(result.scene)), "ring"};
}

std::vector<Image8> ReadMasks(const ImageSet& set) {
  std::vector<Image8> masks(set.images.size());
  ParallelFor(static_cast<std::int64_t>(masks.size()), [&](std::int64_t i) {
    if (!set.images[static_cast<std::size_t>(i)].mask.empty())
      masks[static_cast<std::size_t>(i)] = ReadImage(set.MaskPath(static_cast<int>(i)), 1);
  });
  return masks;
}

/// The last rung: no feature counts, only outlines. Of the layouts the one whose outlines agree best.
Placed PlaceBySilhouettes(StageContext& stage, const ImageSet& set, const Seen& seen, const std::vector<RingLayout>& layouts) {
  const std::vector<std::string> names = NamesOf(set);
  const std::vector<Image8> masks = ReadMasks(set);
  RingSilhouettes best;
  std::string reason;
  for (std::size_t k = 0; k < layouts.size(); ++k) {
    const double share = 0.09 / static_cast<double>(layouts.size());
    SubProgress part(stage.progress(), 0.88 + share * static_cast<double>(k), 0.88 + share * static_cast<double>(k + 1));
    RingSilhouettes fit = FitRingToSilhouettes(seen.camera, layouts[k], masks, {}, &part);
    if (fit.view_error_px.empty() || (!best.view_error_px.empty() && fit.error_px >= 0.9 * best.error_px)) continue;
    best = std::move(fit);
    reason = layouts[k].reason;
  }
  if (best.view_error_px.empty()) return {{}, "silhouettes"};
  stage.Report("silhouette_layout", reason);
  stage.Report("silhouette_error_px", best.error_px);
  if (!best.found) return {{}, "silhouettes"};
  Placed placed{ModelOf(SceneOf(best.model, names, best.points)), "silhouettes"};
  ColorPoints(set, placed.model.scene);
  return placed;
}

/// The rungs that need matched features: plate and mapper.
Placed PlaceByMatches(StageContext& stage, const ImageSet& set, const SfmFiles& files, const SfmOptions& options, const Seen& seen,
                      const SetBoards& boards, Stopwatch& watch) {
  Placed best;
  if (options.method == "auto" || options.method == "board") {
    auto model = ModelFromBoards(stage, set, files, {seen.features, seen.matches}, boards, options);
    if (model) best = PlaceKnown(stage, std::move(*model), "plate", options);
    watch.Lap(stage, "board");
    if (best.views() >= options.min_placed * static_cast<double>(set.images.size()) && best.views() > 0) return best;
  }
  if (options.method == "auto" || options.method == "features") {
    Placed features = PlaceByFeatures(stage, set, files, options, seen, boards);
    if (features.views() > best.views()) best = std::move(features);
    watch.Lap(stage, "mapping");
  }
  return best;
}

/// The rungs that believe in a turntable. `best` is what was found before.
void PlaceByTurntable(StageContext& stage, const ImageSet& set, const SfmFiles& files, const SfmOptions& options, const Seen& seen,
                      Placed& best, Stopwatch& watch) {
  std::vector<RingLayout> layouts = options.Layouts(NamesOf(set));
  if (best.views() < set.images.size() && (options.method == "auto" || options.method == "ring")) {
    Placed ring = PlaceByRing(stage, set, options, seen, layouts);
    watch.Lap(stage, "ring");
    if (ring.views() == 0) {
      if (auto sorted = SortedLayout(stage, set, files, options, seen, best.model.scene)) {
        layouts.insert(layouts.begin(), std::move(*sorted));
        ring = PlaceByRing(stage, set, options, seen, {layouts[0]});
      }
      watch.Lap(stage, "ring_order");
    }
    if (ring.views() > best.views()) best = std::move(ring);
  }
  const bool too_few = static_cast<double>(best.views()) < options.min_placed * static_cast<double>(set.images.size());
  if (options.method == "silhouettes" || (options.method == "auto" && too_few)) {
    Placed outlines = PlaceBySilhouettes(stage, set, seen, layouts);
    watch.Lap(stage, "silhouettes");
    if (outlines.views() > best.views()) best = std::move(outlines);
  }
}

/// Whether cameras hang on so few points that a wrong camera can explain them: 57 a view bent a ring of 20 by 2 % and made its pixels
/// twice as high as wide. Photographs with texture give some hundreds.
bool Thin(const Placed& placed) {
  constexpr double kLeastObservations = 100;  // of a view, on average
  return placed.method == "features" && placed.views() > 0 &&
         static_cast<double>(placed.model.observations.size()) < kLeastObservations * static_cast<double>(placed.views());
}

SfmFiles FilesOf(const ImageSet& set, const fs::path& scratch, bool fine) {
  return {scratch, set.folder, scratch / (fine ? "fine.db" : "coarse.db")};
}

}  // namespace

Placed Place(StageContext& stage, const ImageSet& set, const fs::path& scratch, const SfmOptions& options, Stopwatch& watch,
             bool& focal_known) {
  // The ring model lives on what little there is: it gets the fine features at once.
  bool fine = options.detail == "fine" || (options.detail == "auto" && options.method == "ring");
  SfmFiles files = FilesOf(set, scratch, fine);
  Seen seen = BuildDatabase(stage, set, files, options, fine, watch);
  focal_known = seen.focal_known;
  if (stage.Has("poses")) return PlaceKnown(stage, ModelFromPoses(stage, set, files, seen.features, options), "poses", options);
  const SetBoards boards = PlaceBoards(stage, set, seen.camera, seen.focal_known, options);
  Placed best = PlaceByMatches(stage, set, files, options, seen, boards, watch);
  const bool thin = Thin(best);
  if (!fine && options.detail == "auto" && (best.views() < set.images.size() || thin) && options.method != "silhouettes") {
    stage.Note("sfm: features at the photographs' own size place " + std::to_string(best.views()) + " of " +
               std::to_string(set.images.size()) + (thin ? ", by few points" : "") + "; looking for finer ones");
    fine = true;
    files = FilesOf(set, scratch, fine);
    seen = BuildDatabase(stage, set, files, options, fine, watch);
    Placed finer = PlaceByMatches(stage, set, files, options, seen, boards, watch);
    if (finer.views() >= best.views()) best = std::move(finer);
  }
  stage.Report("fine_features", fine);
  // A figure that was turned over between two halves stands on no one turntable: what the other rungs would find for both is wrong.
  if (boards.groups.size() <= 1) PlaceByTurntable(stage, set, files, options, seen, best, watch);
  return best;
}

}  // namespace keypose::reconstruct
