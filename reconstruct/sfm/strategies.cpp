#include "reconstruct/sfm/strategies.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "core/io/pictures/image_set.h"
#include "core/values/tuned.h"
#include "reconstruct/bundle/track_selection.h"
#include "reconstruct/sfm/room_strategy.h"
#include "reconstruct/sfm/set_overlap.h"
#include "reconstruct/sfm/surroundings.h"
#include "reconstruct/sfm/turntable_strategies.h"

namespace keypose::reconstruct {
namespace fs = std::filesystem;
using nlohmann::json;

namespace {

/// Chosen on a ring of 20 that 57 points per view bent by 2 %; photographs with texture have
/// several hundred. Sensitivity: docs/results/sensitivity.md.
struct FewPointsTuning {
  KEYPOSE_TUNED(double, kLeastObservations, 100);  ///< of a view, on average
};

constexpr std::size_t kFocalsOfWhole = 3;

/// Whether a camera's pixels are far from square, as no camera's are. A ring at one height lets the
/// focal lengths drift apart where few points hold them.
bool HasOddPixels(const Scene& scene) {
  constexpr double kMost = 0.02;
  return std::any_of(scene.views.begin(), scene.views.end(), [](const View& view) {
    return std::abs(view.camera.fy / view.camera.fx - 1) > kMost;
  });
}

Scene WithSquarePixels(Scene scene) {
  for (View& view : scene.views)
    view.camera.fx = view.camera.fy = std::sqrt(view.camera.fx * view.camera.fy);
  return scene;
}

/// The model after another adjustment with a robust loss. Known poses stay fixed; models without
/// observations of points and boards stay unchanged.
PosedModel Refined(StageContext& stage, PosedModel model, const SfmOptions& options,
                   Measurements& measurements) {
  if (model.fixed || (model.observations.empty() && model.bodies.observations.empty()))
    return model;
  const PointSet some = SpreadPoints(model.scene, model.observations, options.adjusted_points);
  BundleOptions bundle = BundleFor(model, options);
  BundleResult result =
      AdjustBundle(some.scene, some.observations, bundle, stage.progress(), model.bodies);
  if (HasOddPixels(result.scene)) {
    bundle.keep_aspect = true;
    result = AdjustBundle(WithSquarePixels(some.scene), some.observations, bundle, stage.progress(),
                          model.bodies);
    measurements.Add("square_pixels", true);
  }
  measurements.Add("colmap_reprojection_error_px", result.before_px);
  measurements.Add("refined_reprojection_error_px", result.after_px);
  measurements.Add("observations_dropped", result.dropped);
  if (!model.bodies.observations.empty()) measurements.Add("board_rms_px", result.bodies_rms_px);
  model.scene = std::move(result.scene);
  model.observations = std::move(result.kept);
  model.bodies = std::move(result.bodies);
  return model;
}

/// @param measurements  of how the model was made; they are added to the result
StrategyResult Adjusted(StageContext& stage, PosedModel model, const std::string& method,
                        const SfmOptions& options, Measurements measurements) {
  ReportProgress(stage.progress(), 0.85, "bundle adjustment");
  StrategyResult result{.method = method, .measurements = std::move(measurements)};
  result.model = Refined(stage, std::move(model), options, result.measurements);
  return result;
}

StrategyResult PlaceByPoses(const StrategyContext& context, const SfmFiles& files,
                            const MatchedFeatures& matched) {
  const auto& [stage, set, options, check, watch] = context;
  Measurements measurements;
  PosedModel model = ModelFromPoses({stage, set, files, matched, options, measurements});
  return Adjusted(stage, std::move(model), "poses", options, std::move(measurements));
}

/// The result has no views if too few photographs show the board.
StrategyResult PlaceByCalibrationBoard(const StrategyContext& context, const SfmFiles& files,
                                       const MatchedFeatures& matched, const SetBoards& boards) {
  const auto& [stage, set, options, check, watch] = context;
  Measurements measurements;
  auto model = ModelFromBoards({stage, set, files, matched, options, measurements}, boards);
  if (!model) return {};
  return context.WithEvidence(
      Adjusted(stage, std::move(*model), "board", options, std::move(measurements)), matched);
}

StrategyResult PlaceByFeatures(const StrategyContext& context, const SfmFiles& files,
                               const MatchedFeatures& matched, const SetBoards& boards) {
  const auto& [stage, set, options, check, watch] = context;
  ReportProgress(stage.progress(), 0.7, "mapping");
  const std::vector<ColmapModel> models = MapImages(stage, files, options);
  StrategyResult result{.method = "features"};
  json sizes = json::array();
  for (const ColmapModel& model : models) sizes.push_back(model.scene.views.size());
  result.measurements.AddJson("model_sizes", sizes.dump());
  if (models.empty()) return result;
  PosedModel model =
      ModelFromMapper({stage, set, files, matched, options, result.measurements}, models, boards);
  if (model.scene.views.size() < 3) {
    result.model.scene = std::move(model.scene);
    return result;
  }
  return context.WithEvidence(
      Adjusted(stage, std::move(model), "features", options, std::move(result.measurements)),
      matched);
}

/// Runs the mapper again with other focal lengths, if no photograph has one in its EXIF data and
/// the first guess gave doubtful cameras: the mapper seldom converges from a guess that is off by a
/// fifth.
StrategyResult PlaceByFeaturesOfAnyFocal(const StrategyContext& context, const SfmFiles& files,
                                         const MatchedFeatures& matched, const SetBoards& boards) {
  StrategyResult best = PlaceByFeatures(context, files, matched, boards);
  const auto is_found = [&](const StrategyResult& result) {
    return matched.in_room ? HasNearlyAll(context, result) : context.IsSettled(result);
  };
  if (is_found(best)) return best;
  std::vector<double> focals = FocalsToTry(matched);
  // Whole photographs determine the focal length: a start from far off is enough.
  if (matched.in_room && focals.size() > kFocalsOfWhole) focals.resize(kFocalsOfWhole);
  for (std::size_t k = 1; k < focals.size(); ++k) {
    ColmapDatabase(files.database).SetFocals(WithFocal(matched.lenses, focals[k]));
    StrategyResult result = PlaceByFeatures(context, files, matched, boards);
    if (result.views() > 0 && result.evidence.Score() > best.evidence.Score())
      best = std::move(result);
    if (matched.in_room && is_found(best)) break;
  }
  if (focals.size() > 1) ColmapDatabase(files.database).SetFocals(matched.lenses);
  return best;
}

/// The strategies that need matched features: board and mapper.
StrategyResult PlaceByMatches(const StrategyContext& context, const SfmFiles& files,
                              const MatchedFeatures& matched, const SetBoards& boards) {
  const auto& [stage, set, options, check, watch] = context;
  StrategyResult best;
  if (options.method == "auto" || options.method == "board") {
    best = PlaceByCalibrationBoard(context, files, matched, boards);
    watch.Lap(stage, "board");
    if (best.views() >= options.min_placed * static_cast<double>(set.images.size()) &&
        best.views() > 0)
      return best;
  }
  if (options.method == "auto" || options.method == "features") {
    StrategyResult features = PlaceByFeaturesOfAnyFocal(context, files, matched, boards);
    if (features.views() > best.views()) best = std::move(features);
    watch.Lap(stage, "mapping");
  }
  return best;
}

/// Whether the model has so few points that wrong cameras can fit them: 57 per view bent a ring of
/// 20 by 2 % and made its pixels twice as high as wide.
bool HasFewPoints(const StrategyResult& result) {
  return result.method == "features" && result.views() > 0 &&
         static_cast<double>(result.model.observations.size()) <
             FewPointsTuning::kLeastObservations * static_cast<double>(result.views());
}

SfmFiles FilesOf(const ImageSet& set, const fs::path& scratch, bool fine) {
  return {scratch, set.folder, scratch / (fine ? "fine.db" : "coarse.db")};
}

/// Whether photographs of one placement, without a board, may be placed by all that stands still
/// with the figure.
bool MayUseSurroundings(const StrategyContext& context) {
  const auto& [stage, set, options, check, watch] = context;
  return options.method == "auto" && options.surroundings != "ignore" && !stage.Has("poses") &&
         std::none_of(set.images.begin(), set.images.end(), [&](const CapturedImage& image) {
           return !image.board_corners.empty() || image.group != set.images.front().group;
         });
}

void NoteFinerFeatures(const StrategyContext& context, const StrategyResult& result,
                       bool few_points, bool settled) {
  const char* doubt = settled ? "" : ", but without certainty";
  if (few_points) doubt = ", with few points";
  context.stage.Note("sfm: features at the photographs' own size place " +
                     std::to_string(result.views()) + " of " +
                     std::to_string(context.set.images.size()) + doubt + "; extracting finer ones");
}

}  // namespace

StrategyResult FindCameras(const StrategyContext& context, const fs::path& scratch,
                           MatchedFeatures& matched) {
  const auto& [stage, set, options, check, watch] = context;
  StrategyResult by_surroundings;
  MatchedFeatures whole;
  const bool in_room = MayUseSurroundings(context) &&
                       (options.surroundings == "use" || HasSurroundings(context, scratch));
  if (in_room) {
    const auto place = [&](const SfmFiles& files, const MatchedFeatures& found) {
      return PlaceByFeaturesOfAnyFocal(context, files, found, {});
    };
    by_surroundings = PlaceBySurroundings(context, scratch, place, whole);
    if (options.surroundings == "use" || IsEnough(context, by_surroundings)) {
      matched = std::move(whole);
      return by_surroundings;
    }
  }
  // The ring model works with few features, so it gets the fine ones at once.
  bool fine = options.detail == "fine" || (options.detail == "auto" && options.method == "ring");
  SfmFiles files = FilesOf(set, scratch, fine);
  matched = BuildDatabase(stage, set, files, options, {.fine = fine}, watch);
  if (stage.Has("poses")) return PlaceByPoses(context, files, matched);
  const SetBoards boards = PlaceBoards(stage, set, matched, options);
  if (options.method == "auto" && boards.groups.size() <= 1 && boards.views() == 0)
    RequireOverlap(stage, set, matched);
  matched.upside_down = FindUpsideDown(stage, set, check, matched);
  StrategyResult best = PlaceByMatches(context, files, matched, boards);
  const bool few_points = HasFewPoints(best), settled = context.IsSettled(best);
  if (!fine && options.detail == "auto" && (!settled || few_points) &&
      options.method != "silhouettes") {
    NoteFinerFeatures(context, best, few_points, settled);
    fine = true;
    files = FilesOf(set, scratch, fine);
    matched = BuildDatabase(stage, set, files, options, {.fine = fine}, watch);
    matched.upside_down = FindUpsideDown(stage, set, check, matched);
    StrategyResult finer = PlaceByMatches(context, files, matched, boards);
    if (!IsBetter(best.evidence, finer.evidence)) best = std::move(finer);
  }
  stage.Report("fine_features", fine);
  // A figure that was turned over between two placements is not on one turntable: the other
  // strategies' results for both would be wrong.
  if (boards.groups.size() > 1) return best;
  // In a room masks are doubtful, and what is judged by outlines would search for long: it fits the
  // masks of a mat that turns with cameras below the table.
  if (in_room) {
    if (by_surroundings.views() > 0 && IsBetter(by_surroundings.evidence, best.evidence)) {
      matched = std::move(whole);
      return by_surroundings;
    }
    best.evidence =
        check.EvaluateSurroundings(best.model.scene, matched.features, matched.verified);
    return best;
  }
  return PlaceByTurntable(context, files, matched, std::move(best));
}

}  // namespace keypose::reconstruct
