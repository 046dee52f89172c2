#include "reconstruct/sfm/final_adjustment.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "core/io/pictures/image_set.h"
#include "core/io/pictures/reduced_image.h"
#include "core/numbers/parallel.h"
#include "core/values/size_of.h"
#include "core/values/tuned.h"
#include "reconstruct/bundle/corner_tracks.h"
#include "reconstruct/bundle/patch_tracks.h"
#include "reconstruct/bundle/track_selection.h"
#include "reconstruct/turntable/ring_fit.h"

namespace keypose::reconstruct {
namespace {

// Measured on 36 photographs of weak and rich clay
// (docs/algorithms/sfm.md); no record of single values. Sensitivity:
// docs/results/sensitivity.md.
struct FinalAdjustmentTuning {
  KEYPOSE_TUNED(int, kFewestPoints, 40);  // with fewer the features' model stays
  // with fewer points, another round adds corners around those of the round before
  KEYPOSE_TUNED(int, kPlenty, 3000);
  KEYPOSE_TUNED(int, kFewestPlaces, 60);  // per view; with fewer its features are kept too
  KEYPOSE_TUNED(int, kFewestSeen, 8);     // per view; with fewer the features' model stays
  // scales of the robust loss of the three rounds
  KEYPOSE_TUNED(double, kFirstRobust_px, 0.5);
  KEYPOSE_TUNED(double, kSecondRobust_px, 0.4);
  KEYPOSE_TUNED(double, kLastRobust_px, 0.3);
  // of the robust loss' scale: observations that err more are dropped
  KEYPOSE_TUNED(double, kMostError, 4);
  // relative standard deviations of a focal length from EXIF and of a guessed one
  KEYPOSE_TUNED(double, kKnownFocal, 0.03);
  KEYPOSE_TUNED(double, kGuessedFocal, 0.15);
};

/// @param max_size_px  photographs that are larger are reduced to this or a little more
/// @param whole  also what is not in the masks
std::vector<PatchImage> ReadPatchImages(const ImageSet& set, const std::vector<View>& views,
                                        int max_size_px, bool whole, const PatchOptions& options) {
  std::vector<PatchImage> images(views.size());
  ParallelFor(std::ssize(views), [&](std::int64_t v) {
    const int i = set.Find(views[v].name);
    const CapturedImage& captured = set.images[i];
    const int eighths = EighthsFor(captured.width, captured.height, max_size_px);
    const Image8 mask =
        whole || captured.mask.empty() ? Image8{} : ReadReduced(set.MaskPath(i), 1, eighths);
    images[v] =
        MakePatchImage(ReadReduced(set.ImagePath(i), 1, eighths), mask, eighths / 8.0, options);
  });
  return images;
}

/// Adds the feature observations of views that have few patches.
void AddFeatures(PatchTracks& tracks, const std::vector<Observation>& features) {
  std::vector<int> places(tracks.scene.views.size(), 0);
  for (const Observation& o : tracks.observations) ++places[o.view];
  int most = -1;
  for (const int p : tracks.source) most = std::max(most, p);
  std::vector<int> index(static_cast<std::size_t>(most + 1), -1);
  for (std::size_t p = 0; p < tracks.source.size(); ++p)
    index[tracks.source[p]] = static_cast<int>(p);
  for (const Observation& o : features) {
    if (places[o.view] >= FinalAdjustmentTuning::kFewestPlaces || o.point > most) continue;
    const int p = index[o.point];
    if (p < 0) continue;
    const std::vector<int>& views = tracks.scene.points[p].views;
    if (std::find(views.begin(), views.end(), o.view) == views.end())
      tracks.observations.push_back({o.view, p, o.pixel});
  }
}

RingFitOptions FittingFor(const PosedModel& model, bool focal_known, const SfmOptions& options) {
  RingFitOptions fitting;
  fitting.bundle = BundleFor(model, options);
  fitting.bundle.keep_aspect = true;  // pixels are square
  fitting.ring.focal_prior =
      focal_known ? FinalAdjustmentTuning::kKnownFocal : FinalAdjustmentTuning::kGuessedFocal;
  return fitting;
}

void ReportFit(StageContext& stage, const RingFit& fit, bool with_board) {
  stage.Report("patch_points", SizeOf(fit.result.scene.points));
  stage.Report("patch_observations", fit.result.observations);
  stage.Report("patch_error_px", fit.result.after_px);
  if (fit.tried) stage.Report("turntable_chi2_ratio", fit.chi2_ratio);
  stage.Report("on_turntable", fit.is_ring);
  if (with_board) stage.Report("board_rms_px", fit.result.bodies_rms_px);
}

bool AllSeen(const Scene& scene, const std::vector<Observation>& observations) {
  std::vector<int> places(scene.views.size(), 0);
  for (const Observation& o : observations) ++places[o.view];
  return std::all_of(places.begin(), places.end(),
                     [](int count) { return count >= FinalAdjustmentTuning::kFewestSeen; });
}

}  // namespace

void ColorPoints(const ImageSet& set, Scene& scene) {
  constexpr int kColoured_px = 2000;  // larger photographs are reduced to this or a little more
  std::vector<std::vector<std::size_t>> of_view(scene.views.size());
  for (std::size_t p = 0; p < scene.points.size(); ++p)
    if (!scene.points[p].views.empty()) of_view[scene.points[p].views[0]].push_back(p);
  ParallelFor(std::ssize(scene.views), [&](std::int64_t v) {
    const View& view = scene.views[v];
    if (of_view[v].empty()) return;
    const int eighths = EighthsFor(view.camera.width, view.camera.height, kColoured_px);
    const Image8 image = ReadReduced(set.ImagePath(set.Find(view.name)), 3, eighths);
    for (const std::size_t p : of_view[v]) {
      const Eigen::Vector2d pixel = eighths / 8.0 * view.Project(scene.points[p].position);
      const int x = std::clamp(static_cast<int>(pixel.x()), 0, image.width - 1),
                y = std::clamp(static_cast<int>(pixel.y()), 0, image.height - 1);
      scene.points[p].color = Eigen::Map<const Eigen::Matrix<std::uint8_t, 3, 1>>(image.at(x, y));
    }
  });
}

Scene RefineByPatches(StageContext& stage, const ImageSet& set, const PosedModel& model,
                      const MatchedFeatures& matched, const SfmOptions& options) {
  if (model.fixed || !options.patches ||
      SizeOf(model.scene.points) < FinalAdjustmentTuning::kFewestPoints)
    return model.scene;
  ReportProgress(stage.progress(), 0.93, "refining points by grey values");
  const PatchOptions patches;
  const std::vector<PatchImage> images =
      ReadPatchImages(set, model.scene.views, options.max_image_size, matched.in_room, patches);
  PointSet current = SpreadPoints(model.scene, model.observations, options.adjusted_points);
  Bodies bodies = model.bodies;
  RingFitOptions fitting = FittingFor(model, matched.focal_known, options);
  // With a single ring of views, the pixels' aspect ratio and the distance would be ambiguous.
  if (!options.refine_distortion && bodies.observations.empty())
    for (View& view : current.scene.views)
      view.camera.fx = view.camera.fy = 0.5 * (view.camera.fx + view.camera.fy);
  const bool ring = matched.lenses.size() == 1 && bodies.observations.empty() &&
                    !options.refine_principal_point && !options.refine_distortion;
  CornerOptions corners;
  corners.most_points = options.adjusted_points;
  RingFit fit;
  PatchTracks tracks;
  for (const double robust_px :
       {FinalAdjustmentTuning::kFirstRobust_px, FinalAdjustmentTuning::kSecondRobust_px,
        FinalAdjustmentTuning::kLastRobust_px}) {
    if (robust_px == FinalAdjustmentTuning::kSecondRobust_px &&
        SizeOf(tracks.scene.points) >= FinalAdjustmentTuning::kPlenty)
      continue;
    tracks = TrackPatches(current.scene, images, patches, stage.progress());
    AddFeatures(tracks, current.observations);
    if (SizeOf(tracks.scene.points) < FinalAdjustmentTuning::kFewestPoints ||
        !AllSeen(tracks.scene, tracks.observations)) {
      stage.Report("patch_points", 0);
      return model.scene;
    }
    fitting.bundle.robust_px = robust_px;
    fitting.bundle.max_error_px = FinalAdjustmentTuning::kMostError * robust_px;
    const bool last = robust_px == FinalAdjustmentTuning::kLastRobust_px;
    if (ring && last)
      fit = AdjustOnRings(tracks.scene, tracks.observations, fitting, stage.progress());
    else
      fit.result =
          AdjustBundle(tracks.scene, tracks.observations, fitting.bundle, stage.progress(), bodies);
    bodies = fit.result.bodies;
    current = {last ? fit.result.scene : AddCorners(fit.result.scene, images, patches, corners),
               fit.result.kept};
  }
  ReportFit(stage, fit, !bodies.observations.empty());
  ColorPoints(set, fit.result.scene);
  return std::move(fit.result.scene);
}

}  // namespace keypose::reconstruct
