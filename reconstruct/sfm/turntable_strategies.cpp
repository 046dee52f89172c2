#include "reconstruct/sfm/turntable_strategies.h"

#include <algorithm>
#include <iterator>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "core/io/pictures/image_io.h"
#include "core/io/pictures/image_set.h"
#include "core/numbers/parallel.h"
#include "core/pictures/image_turns.h"
#include "core/values/errors.h"
#include "core/values/tuned.h"
#include "reconstruct/sfm/final_adjustment.h"
#include "reconstruct/turntable/ring_order.h"
#include "reconstruct/turntable/ring_sfm.h"
#include "reconstruct/turntable/ring_silhouettes.h"
#include "reconstruct/turntable/upside_down.h"

namespace keypose::reconstruct {
namespace {

using nlohmann::json;

/// No record of the data. Sensitivity: docs/results/sensitivity.md.
struct TurntableTuning {
  /// relative standard deviation of a focal length that was guessed
  KEYPOSE_TUNED(double, kGuessedFocal, 0.15);
  /// error of a layout with more rings, and so more unknowns, over the best so far
  KEYPOSE_TUNED(double, kClearlyBetter, 0.9);
};

/// The features with all photographs upright.
struct Upright {
  Camera camera;
  std::vector<Features> features;
};

std::vector<Features> UprightFeatures(const MatchedFeatures& matched) {
  std::vector<Features> features = matched.features;
  for (std::size_t i = 0; i < features.size(); ++i) {
    if (!matched.upside_down[i]) continue;
    auto& positions = features[i].positions;
    positions.col(0) = static_cast<float>(matched.camera.width) - positions.col(0).array();
    positions.col(1) = static_cast<float>(matched.camera.height) - positions.col(1).array();
  }
  return features;
}

/// Rotates the cameras of photographs that were rotated back with them.
void TurnBack(const ImageSet& set, const MatchedFeatures& matched, Scene& scene) {
  const Rigid3 over{Eigen::Quaterniond(0, 0, 0, 1), Eigen::Vector3d::Zero()};
  for (View& view : scene.views) {
    const auto image = static_cast<std::size_t>(set.Find(view.name));
    if (matched.upside_down[image]) view.camera_from_world = Compose(over, view.camera_from_world);
  }
}

/// A result without observations.
StrategyResult ResultOf(const StrategyContext& context, const MatchedFeatures& matched, Scene scene,
                        const std::string& method) {
  StrategyResult result{.method = method};
  result.model.scene = std::move(scene);
  TurnBack(context.set, matched, result.model.scene);
  ColorPoints(context.set, result.model.scene);
  return context.WithEvidence(std::move(result), matched);
}

void Measure(const RingSfmResult& ring, Measurements& measurements) {
  measurements.Add("ring_layout", ring.layout.reason);
  measurements.Add("ring_matches", ring.start.matches);
  measurements.Add("ring_inliers", ring.start.inliers);
  measurements.Add("ring_inlier_share", ring.start.inlier_share);
  measurements.Add("ring_error_px", ring.ring_error_px);
  measurements.Add("ring_free_chi2_ratio", ring.chi2_ratio);
  measurements.Add("ring_freed", ring.freed);
  measurements.AddJson("ring_slop_deg", json(ring.slop_deg).dump());
  measurements.AddJson("placed_by_step_only", json(ring.by_step_only).dump());
}

/// A layout whose order does not follow from the names.
struct SortedRings {
  RingLayout layout;
  std::string names_in_order;  ///< JSON, ring by ring
  int sorted = 0;              ///< photographs
};

/// Estimates the order of the photographs on their rings from their content, where names do not
/// give it.
std::optional<SortedRings> SortRings(const StrategyContext& context, const SfmFiles& files,
                                     const MatchedFeatures& matched, const Scene& known) {
  const auto& [stage, set, options, check, watch] = context;
  if (options.rings != "auto") return std::nullopt;
  Scene part = known;
  if (part.views.empty() && options.method == "ring")
    if (auto models = MapImages(stage, files, options); !models.empty())
      part = std::move(models[0].scene);
  const std::vector<std::string> names = NamesOf(set);
  const auto order = OrderOnRings(part, names, PointsOf(matched.matches, matched.features));
  if (!order) return std::nullopt;
  json rings = json::array();
  for (const auto& ring : order->layout.rings) {
    json in_order = json::array();
    for (const RingLayout::Place& place : ring) in_order.push_back(names[place.image]);
    rings.push_back(std::move(in_order));
  }
  return SortedRings{order->layout, rings.dump(), order->sorted};
}

/// Adds the measurements of a result whose order was estimated.
void Measure(const SortedRings& rings, std::size_t photographs, Measurements& measurements) {
  measurements.AddJson("order_found", rings.names_in_order);
  measurements.Warn(
      "the names of the photographs do not give the order in which they were shot; sorted " +
      std::to_string(rings.sorted) + " of " + std::to_string(photographs) +
      " by their content: " + rings.layout.reason);
}

RingSfmOptions RingOptionsOf(const SfmOptions& options, const MatchedFeatures& matched) {
  RingSfmOptions ring;
  ring.matching.max_ratio = options.max_ratio;
  ring.bundle.refine_principal_point = options.refine_principal_point;
  ring.bundle.refine_distortion = options.refine_distortion;
  if (!matched.focal_known) ring.ring.focal_prior = TurntableTuning::kGuessedFocal;
  return ring;
}

/// The ring model with the best evidence, over the possible focal lengths and layouts. No views
/// where none fits.
StrategyResult PlaceByRing(const StrategyContext& context, const Upright& upright,
                           const MatchedFeatures& matched, const std::vector<RingLayout>& layouts) {
  const std::vector<std::string> names = NamesOf(context.set);
  const std::vector<double> focals = FocalsToTry(matched);
  const RingSfmOptions options = RingOptionsOf(context.options, matched);
  StrategyResult best{.method = "ring"};
  std::vector<RingLayout> tried = layouts;
  for (std::size_t k = 0; k < focals.size(); ++k) {
    const double share = 0.09 / static_cast<double>(focals.size());
    SubProgress part(context.stage.progress(), 0.88 + share * static_cast<double>(k),
                     0.88 + share * static_cast<double>(k + 1));
    const Camera camera = WithFocal(upright.camera, focals[k]);
    const RingSfmResult ring =
        ReconstructRing(camera, names, upright.features, matched.matches, tried, options, &part);
    if (!ring.found) continue;
    tried = {ring.layout};  // the layout does not depend on the focal length
    StrategyResult result = ResultOf(context, matched, ring.scene, "ring");
    if (best.views() > 0 && result.evidence.Score() <= best.evidence.Score()) continue;
    Measure(ring, result.measurements);
    best = std::move(result);
  }
  return best;
}

std::vector<Image8> ReadMasks(const ImageSet& set, const std::vector<char>& upside_down) {
  std::vector<Image8> masks(set.images.size());
  ParallelFor(std::ssize(masks), [&](std::int64_t i) {
    const auto k = static_cast<std::size_t>(i);
    if (set.images[k].mask.empty()) return;
    masks[k] = ReadImage(set.MaskPath(static_cast<int>(i)), 1);
    if (upside_down[k]) masks[k] = TurnedOver(masks[k]);
  });
  return masks;
}

/// A ring model that fits the outlines, and the index of its layout.
struct OutlineFit {
  RingSilhouettes ring;
  std::size_t layout = 0;
};

/// The layout and the focal length that fit the outlines best. Focal lengths are tried with the
/// layout that was best for the first of them.
OutlineFit FitOutlines(const StrategyContext& context, const MatchedFeatures& matched,
                       const std::vector<Image8>& masks, const std::vector<RingLayout>& layouts) {
  OutlineFit best;
  const std::vector<double> focals = FocalsToTry(matched);
  const auto fits = static_cast<double>(layouts.size() + focals.size() - 1);
  int done = 0;
  const auto fit = [&](std::size_t layout, double focal_px) {
    const double share = 0.09 / fits;
    SubProgress part(context.stage.progress(), 0.88 + share * done, 0.88 + share * (done + 1));
    ++done;
    return FitRingToSilhouettes(WithFocal(matched.camera, focal_px), layouts[layout], masks, {},
                                &part);
  };
  const auto none = [](const RingSilhouettes& found) { return found.view_error_px.empty(); };
  for (std::size_t k = 0; k < layouts.size(); ++k) {
    RingSilhouettes found = fit(k, focals[0]);
    // A layout with more rings has more unknowns, so it must be clearly better.
    if (none(found) || (!none(best.ring) &&
                        found.error_px >= TurntableTuning::kClearlyBetter * best.ring.error_px))
      continue;
    best = {std::move(found), k};
  }
  if (none(best.ring)) return best;
  for (std::size_t k = 1; k < focals.size(); ++k) {
    RingSilhouettes found = fit(best.layout, focals[k]);
    if (!none(found) && found.error_px < best.ring.error_px) best.ring = std::move(found);
  }
  return best;
}

/// The last strategy uses outlines only, without features. No views if it does not fit.
/// @param sorted  the first of the layouts, if its order was estimated from the photographs'
/// content
StrategyResult PlaceBySilhouettes(const StrategyContext& context, const MatchedFeatures& matched,
                                  const std::vector<RingLayout>& layouts,
                                  const std::optional<SortedRings>& sorted) {
  const OutlineFit best =
      FitOutlines(context, matched, ReadMasks(context.set, matched.upside_down), layouts);
  if (best.ring.view_error_px.empty() || !best.ring.found) return {.method = "silhouettes"};
  Scene scene = SceneOf(best.ring.model, NamesOf(context.set), best.ring.points);
  StrategyResult result = ResultOf(context, matched, std::move(scene), "silhouettes");
  result.measurements.Add("silhouette_layout", layouts[best.layout].reason);
  result.measurements.Add("silhouette_error_px", best.ring.error_px);
  if (sorted && best.layout == 0) Measure(*sorted, context.set.images.size(), result.measurements);
  return result;
}

/// The layout that a shooting session has noted, if it has one of all photographs and the figure
/// stood in one way: each placement has a table frame of its own.
std::optional<RingLayout> NotedLayout(const ImageSet& set) {
  std::vector<int> rings;
  std::vector<double> angles_deg;
  for (const CapturedImage& image : set.images) {
    if (!image.place || image.place->flip != set.images[0].place->flip) return std::nullopt;
    rings.push_back(image.place->ring);
    angles_deg.push_back(image.place->angle_deg);
  }
  return LayoutOfAngles(rings, angles_deg);
}

/// Whether the photographs can be of one camera on a tripod, as these strategies assume.
/// @throws InputError  they cannot, and the method asks for such a strategy
bool HaveOneSize(const SfmOptions& options, const MatchedFeatures& matched) {
  const auto other = [&](const Camera& lens) {
    return lens.width != matched.camera.width || lens.height != matched.camera.height;
  };
  const auto found = std::find_if(matched.lenses.begin(), matched.lenses.end(), other);
  if (found == matched.lenses.end()) return true;
  if (options.method == "ring" || options.method == "silhouettes")
    throw InputError("sfm: --method " + options.method +
                     " is for photographs of one camera on a tripod, but these have different "
                     "sizes: " +
                     std::to_string(matched.camera.width) + " x " +
                     std::to_string(matched.camera.height) + " and " +
                     std::to_string(found->width) + " x " + std::to_string(found->height) +
                     "; use --method auto or features, or leave out those of one size");
  return false;
}

}  // namespace

StrategyResult PlaceByTurntable(const StrategyContext& context, const SfmFiles& files,
                                const MatchedFeatures& matched, StrategyResult best) {
  const auto& [stage, set, options, check, watch] = context;
  if (!HaveOneSize(options, matched)) return best;
  std::vector<RingLayout> layouts = options.Layouts(NamesOf(set));
  if (const auto noted = NotedLayout(set); noted && options.rings == "auto")
    layouts.insert(layouts.begin(), *noted);
  std::optional<SortedRings> sorted;
  if (!context.IsSettled(best) && (options.method == "auto" || options.method == "ring")) {
    const Upright upright{matched.camera, UprightFeatures(matched)};
    StrategyResult ring = PlaceByRing(context, upright, matched, layouts);
    watch.Lap(stage, "ring");
    if (ring.views() == 0) {
      sorted = SortRings(context, files, matched, best.model.scene);
      if (sorted) {
        layouts.insert(layouts.begin(), sorted->layout);
        ring = PlaceByRing(context, upright, matched, {sorted->layout});
        Measure(*sorted, set.images.size(), ring.measurements);
      }
      watch.Lap(stage, "ring_order");
    }
    best = BetterOf(std::move(best), std::move(ring));
  }
  const bool too_few = static_cast<double>(best.views()) <
                       options.min_placed * static_cast<double>(set.images.size());
  const bool wrong = best.model.scale_source == "none" && !IsPlausible(best.evidence);
  if (options.method == "silhouettes" || (options.method == "auto" && (too_few || wrong))) {
    best = BetterOf(std::move(best), PlaceBySilhouettes(context, matched, layouts, sorted));
    watch.Lap(stage, "silhouettes");
  }
  return best;
}

}  // namespace keypose::reconstruct
