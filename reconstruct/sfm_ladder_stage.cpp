#include "reconstruct/sfm_ladder_stage.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>

#include "core/io/colmap_io.h"
#include "core/io/image_set.h"
#include "reconstruct/sfm_overlap_stage.h"
#include "reconstruct/sfm_thin.h"
#include "reconstruct/sfm_turntable_stage.h"

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
  return {Refined(stage, std::move(model), options), method, {}};
}

/// Without observations of its own.
PlacedModel ModelOf(Scene scene) {
  PlacedModel model;
  model.scene = std::move(scene);
  return model;
}

Placed PlaceByFeatures(const Ladder& ladder, const SfmFiles& files, const Seen& seen, const SetBoards& boards) {
  const auto& [stage, set, options, judge, watch] = ladder;
  Step(stage.progress(), 0.7, "mapping");
  const auto models = MapImages(stage, files, options);
  Placed placed{{}, "features", {}};
  json sizes = json::array();
  for (const fs::path& model : models) sizes.push_back(ReadColmapModel(model).views.size());
  stage.ReportJson("model_sizes", sizes.dump());
  if (models.empty()) return placed;
  PlacedModel model = ModelFromMapper(stage, set, files, {seen.features, seen.matches}, models, boards, options);
  if (model.scene.views.size() < 3) return {ModelOf(std::move(model.scene)), "features", {}};
  return ladder.Judged(PlaceKnown(stage, std::move(model), "features", options), seen);
}

/// Maps again from other focal lengths, where no photograph tells it and the first guess gave doubtful cameras: the mapper seldom finds its
/// way from a guess that is a fifth off.
Placed PlaceByFeaturesOfAnyFocal(const Ladder& ladder, const SfmFiles& files, const Seen& seen, const SetBoards& boards) {
  Placed best = PlaceByFeatures(ladder, files, seen, boards);
  if (ladder.IsSettled(best)) return best;
  const std::vector<double> focals = FocalsToTry(seen);
  for (std::size_t k = 1; k < focals.size(); ++k) {
    ColmapDatabase(files.database).SetFocal(WithFocal(seen.camera, focals[k]));
    Placed placed = PlaceByFeatures(ladder, files, seen, boards);
    if (placed.views() > 0 && placed.evidence.Score() > best.evidence.Score()) best = std::move(placed);
  }
  if (focals.size() > 1) ColmapDatabase(files.database).SetFocal(seen.camera);
  return best;
}

/// The rungs that need matched features: plate and mapper.
Placed PlaceByMatches(const Ladder& ladder, const SfmFiles& files, const Seen& seen, const SetBoards& boards) {
  const auto& [stage, set, options, judge, watch] = ladder;
  Placed best;
  if (options.method == "auto" || options.method == "board") {
    auto model = ModelFromBoards(stage, set, files, {seen.features, seen.matches}, boards, options);
    if (model) best = ladder.Judged(PlaceKnown(stage, std::move(*model), "plate", options), seen);
    watch.Lap(stage, "board");
    if (best.views() >= options.min_placed * static_cast<double>(set.images.size()) && best.views() > 0) return best;
  }
  if (options.method == "auto" || options.method == "features") {
    Placed features = PlaceByFeaturesOfAnyFocal(ladder, files, seen, boards);
    if (features.views() > best.views()) best = std::move(features);
    watch.Lap(stage, "mapping");
  }
  return best;
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

/// Every `step`-th view, for a quick judgement.
Scene SomeViews(const Scene& scene, std::size_t most) {
  if (scene.views.size() <= most) return scene;
  Scene some;
  for (std::size_t k = 0; k < most; ++k) some.views.push_back(scene.views[k * scene.views.size() / most]);
  return some;
}

}  // namespace

Placed Ladder::Judged(Placed placed, const Seen& seen) const {
  constexpr std::size_t kMostViews = 32;
  placed.evidence = judge.Judge(SomeViews(placed.model.scene, kMostViews), seen.features, seen.verified);
  placed.evidence.placed = static_cast<int>(placed.views());
  return placed;
}

bool Ladder::IsSettled(const Placed& placed) const {
  if (placed.views() < set.images.size()) return false;
  return placed.model.scale_source != "none" || IsSure(placed.evidence);
}

Placed Place(const Ladder& ladder, const fs::path& scratch, Seen& seen) {
  const auto& [stage, set, options, judge, watch] = ladder;
  // The ring model lives on what little there is: it gets the fine features at once.
  bool fine = options.detail == "fine" || (options.detail == "auto" && options.method == "ring");
  SfmFiles files = FilesOf(set, scratch, fine);
  seen = BuildDatabase(stage, set, files, options, fine, watch);
  if (stage.Has("poses")) return PlaceKnown(stage, ModelFromPoses(stage, set, files, seen.features, options), "poses", options);
  const SetBoards boards = PlaceBoards(stage, set, seen.camera, seen.focal_known, options);
  if (options.method == "auto" && boards.groups.size() <= 1 && boards.views() == 0) RequireOverlap(stage, set, seen);
  seen.upside_down = FindUpsideDown(stage, set, judge, seen);
  Placed best = PlaceByMatches(ladder, files, seen, boards);
  const bool thin = Thin(best), settled = ladder.IsSettled(best);
  if (!fine && options.detail == "auto" && (!settled || thin) && options.method != "silhouettes") {
    stage.Note("sfm: features at the photographs' own size place " + std::to_string(best.views()) + " of " +
               std::to_string(set.images.size()) +
               (thin      ? ", by few points"
                : settled ? ""
                          : ", not surely") +
               "; looking for finer ones");
    fine = true;
    files = FilesOf(set, scratch, fine);
    seen = BuildDatabase(stage, set, files, options, fine, watch);
    seen.upside_down = FindUpsideDown(stage, set, judge, seen);
    Placed finer = PlaceByMatches(ladder, files, seen, boards);
    if (!IsBetter(best.evidence, finer.evidence)) best = std::move(finer);
  }
  stage.Report("fine_features", fine);
  // A figure that was turned over between two halves stands on no one turntable: what the other rungs would find for both is wrong.
  if (boards.groups.size() <= 1) PlaceByTurntable(ladder, files, seen, best);
  return best;
}

}  // namespace keypose::reconstruct
