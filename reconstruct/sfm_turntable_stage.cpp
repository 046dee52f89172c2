#include "reconstruct/sfm_turntable_stage.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>

#include "core/image_turns.h"
#include "core/io/colmap_io.h"
#include "core/io/image_io.h"
#include "core/io/image_set.h"
#include "core/parallel.h"
#include "reconstruct/ring_order.h"
#include "reconstruct/ring_sfm.h"
#include "reconstruct/ring_silhouettes.h"
#include "reconstruct/sfm_refine_stage.h"
#include "reconstruct/upside_down.h"

namespace keypose::reconstruct {
namespace {

using nlohmann::json;

/// What the photographs show with all of them upright.
struct Upright {
  Camera camera;
  std::vector<Features> features;
};

std::vector<Features> UprightFeatures(const Seen& seen) {
  std::vector<Features> features = seen.features;
  for (std::size_t i = 0; i < features.size(); ++i) {
    if (!seen.upside_down[i]) continue;
    features[i].positions.col(0) = static_cast<float>(seen.camera.width) - features[i].positions.col(0).array();
    features[i].positions.col(1) = static_cast<float>(seen.camera.height) - features[i].positions.col(1).array();
  }
  return features;
}

/// Cameras of photographs that were turned over go back with them.
void TurnBack(const ImageSet& set, const Seen& seen, Scene& scene) {
  const Rigid3 over{Eigen::Quaterniond(0, 0, 0, 1), Eigen::Vector3d::Zero()};
  for (View& view : scene.views)
    if (seen.upside_down[static_cast<std::size_t>(set.Find(view.name))]) view.camera_from_world = Compose(over, view.camera_from_world);
}

/// Without observations of its own.
Placed PlacedWith(const Ladder& ladder, const Seen& seen, Scene scene, const std::string& method) {
  Placed placed;
  placed.method = method;
  placed.model.scene = std::move(scene);
  TurnBack(ladder.set, seen, placed.model.scene);
  ColorPoints(ladder.set, placed.model.scene);
  return ladder.Judged(std::move(placed), seen);
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
std::optional<RingLayout> SortedLayout(const Ladder& ladder, const SfmFiles& files, const Seen& seen, const Scene& known) {
  const auto& [stage, set, options, judge, watch] = ladder;
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
  stage.Warn("the names of the photographs do not tell in which order they were shot; sorted " + std::to_string(order->sorted) + " of " +
             std::to_string(names.size()) + " by what they show: " + order->layout.reason);
  return order->layout;
}

RingSfmOptions RingOptionsOf(const SfmOptions& options, const Seen& seen) {
  RingSfmOptions ring;
  ring.matching.max_ratio = options.max_ratio;
  ring.bundle.refine_principal_point = options.refine_principal_point;
  ring.bundle.refine_distortion = options.refine_distortion;
  if (!seen.focal_known) ring.ring.focal_prior = 0.15;
  return ring;
}

/// Of the focal lengths that may be, and of the layouts, those whose ring model the evidence prefers.
Placed PlaceByRing(const Ladder& ladder, const Upright& upright, const Seen& seen, const std::vector<RingLayout>& layouts) {
  const std::vector<std::string> names = NamesOf(ladder.set);
  const std::vector<double> focals = FocalsToTry(seen);
  const RingSfmOptions options = RingOptionsOf(ladder.options, seen);
  Placed best{{}, "ring", {}};
  std::optional<RingSfmResult> reported;
  std::vector<RingLayout> tried = layouts;
  for (std::size_t k = 0; k < focals.size(); ++k) {
    const double share = 0.09 / static_cast<double>(focals.size());
    SubProgress part(ladder.stage.progress(), 0.88 + share * static_cast<double>(k), 0.88 + share * static_cast<double>(k + 1));
    RingSfmResult result =
        ReconstructRing(WithFocal(upright.camera, focals[k]), names, upright.features, seen.matches, tried, options, &part);
    if (!reported) reported = result;
    if (!result.found) continue;
    tried = {result.layout};  // the order of shooting does not hang on the focal length
    Placed placed = PlacedWith(ladder, seen, result.scene, "ring");
    if (best.views() > 0 && placed.evidence.Score() <= best.evidence.Score()) continue;
    best = std::move(placed);
    reported = std::move(result);
  }
  if (reported) ReportRing(ladder.stage, *reported);
  return best;
}

std::vector<Image8> ReadMasks(const ImageSet& set, const std::vector<char>& upside_down) {
  std::vector<Image8> masks(set.images.size());
  ParallelFor(static_cast<std::int64_t>(masks.size()), [&](std::int64_t i) {
    const auto k = static_cast<std::size_t>(i);
    if (set.images[k].mask.empty()) return;
    masks[k] = ReadImage(set.MaskPath(static_cast<int>(i)), 1);
    if (upside_down[k]) masks[k] = TurnedOver(masks[k]);
  });
  return masks;
}

/// The layout and the focal length for which outlines agree best. Focal lengths are tried with the layout that won at the first of them.
RingSilhouettes FitOutlines(const Ladder& ladder, const Seen& seen, const std::vector<Image8>& masks,
                            const std::vector<RingLayout>& layouts, std::string& reason) {
  RingSilhouettes best;
  std::size_t chosen = 0;
  const std::vector<double> focals = FocalsToTry(seen);
  const auto fits = static_cast<double>(layouts.size() + focals.size() - 1);
  int done = 0;
  const auto fit = [&](std::size_t layout, double focal_px) {
    const double share = 0.09 / fits;
    SubProgress part(ladder.stage.progress(), 0.88 + share * done, 0.88 + share * (done + 1));
    ++done;
    return FitRingToSilhouettes(WithFocal(seen.camera, focal_px), layouts[layout], masks, {}, &part);
  };
  for (std::size_t k = 0; k < layouts.size(); ++k) {
    RingSilhouettes found = fit(k, focals[0]);
    // A layout of more rings has more unknowns: it has to be clearly better.
    if (found.view_error_px.empty() || (!best.view_error_px.empty() && found.error_px >= 0.9 * best.error_px)) continue;
    best = std::move(found);
    chosen = k;
    reason = layouts[k].reason;
  }
  if (best.view_error_px.empty()) return best;
  for (std::size_t k = 1; k < focals.size(); ++k)
    if (RingSilhouettes found = fit(chosen, focals[k]); !found.view_error_px.empty() && found.error_px < best.error_px)
      best = std::move(found);
  return best;
}

/// The last rung: no feature counts, only outlines.
Placed PlaceBySilhouettes(const Ladder& ladder, const Seen& seen, const std::vector<RingLayout>& layouts) {
  std::string reason;
  const RingSilhouettes best = FitOutlines(ladder, seen, ReadMasks(ladder.set, seen.upside_down), layouts, reason);
  if (best.view_error_px.empty()) return {{}, "silhouettes", {}};
  ladder.stage.Report("silhouette_layout", reason);
  ladder.stage.Report("silhouette_error_px", best.error_px);
  if (!best.found) return {{}, "silhouettes", {}};
  return PlacedWith(ladder, seen, SceneOf(best.model, NamesOf(ladder.set), best.points), "silhouettes");
}

/// A strategy that was asked for by name stands by itself; else the evidence decides.
void Take(Placed candidate, Placed& best) {
  if (IsBetter(candidate.evidence, best.evidence)) best = std::move(candidate);
}

}  // namespace

std::vector<double> FocalsToTry(const Seen& seen) {
  if (seen.focal_known) return {seen.camera.fx};
  const double side = std::max(seen.camera.width, seen.camera.height);
  std::vector<double> focals;
  for (const double times : {1.2, 1.45, 1.75, 1.0, 2.1, 0.85, 2.55}) focals.push_back(times * side);
  focals[0] = seen.camera.fx;
  return focals;
}

Camera WithFocal(Camera camera, double focal_px) {
  camera.fx = camera.fy = focal_px;
  return camera;
}

void PlaceByTurntable(const Ladder& ladder, const SfmFiles& files, const Seen& seen, Placed& best) {
  const SfmOptions& options = ladder.options;
  std::vector<RingLayout> layouts = options.Layouts(NamesOf(ladder.set));
  if (!ladder.IsSettled(best) && (options.method == "auto" || options.method == "ring")) {
    const Upright upright{seen.camera, UprightFeatures(seen)};
    Placed ring = PlaceByRing(ladder, upright, seen, layouts);
    ladder.watch.Lap(ladder.stage, "ring");
    if (ring.views() == 0) {
      if (auto sorted = SortedLayout(ladder, files, seen, best.model.scene)) {
        layouts.insert(layouts.begin(), std::move(*sorted));
        ring = PlaceByRing(ladder, upright, seen, {layouts[0]});
      }
      ladder.watch.Lap(ladder.stage, "ring_order");
    }
    Take(std::move(ring), best);
  }
  const bool too_few = static_cast<double>(best.views()) < options.min_placed * static_cast<double>(ladder.set.images.size());
  const bool wrong = best.model.scale_source == "none" && !CanBeRight(best.evidence);
  if (options.method == "silhouettes" || (options.method == "auto" && (too_few || wrong))) {
    Take(PlaceBySilhouettes(ladder, seen, layouts), best);
    ladder.watch.Lap(ladder.stage, "silhouettes");
  }
}

}  // namespace keypose::reconstruct
