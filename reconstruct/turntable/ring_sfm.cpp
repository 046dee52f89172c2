#include "reconstruct/turntable/ring_sfm.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "core/numbers/parallel.h"
#include "core/values/angles.h"
#include "core/values/tuned.h"
#include "reconstruct/matching/guided_matching.h"
#include "reconstruct/turntable/ring_tracks.h"

namespace keypose::reconstruct {
namespace {

/// Measured on 24 photographs of weak clay (docs/results/cameras.md); no record of single values.
/// Sensitivity: docs/results/sensitivity.md.
struct RingSfmTuning {
  /// px: largest distance of a raw match from its epipolar line, and of its point from both places
  KEYPOSE_TUNED(double, kRawMatch_px, 5);
  KEYPOSE_TUNED(double, kRawPoint_px, 12);
  /// px: largest distances of matches along epipolar lines, in the first and second round
  KEYPOSE_TUNED(double, kFirstMatch_px, 4);
  KEYPOSE_TUNED(double, kSecondMatch_px, 2.5);
  KEYPOSE_TUNED(double, kPoint_px, 6);   ///< px: of their points from both places
  KEYPOSE_TUNED(double, kFreePoint, 4);  ///< the same with free cameras, over the match's distance
  KEYPOSE_TUNED(double, kLeastAngle_deg, 4);  ///< between some two rays of a point
  /// inliers of a further layout over those of the best so far
  KEYPOSE_TUNED(double, kBetterLayout, 1.1);
};

class Reconstruction {
 public:
  Reconstruction(const std::vector<std::string>& names, const std::vector<Features>& features,
                 const RingSfmOptions& options)
      : names_(names), features_(features), options_(options) {}

  RingSfmResult Run(const Camera& camera, const std::vector<PairMatches>& matches,
                    const std::vector<RingLayout>& layouts, Progress* progress) {
    ChooseLayout(camera, PointsOf(matches, features_), layouts, progress);
    if (!result_.start.IsPlausible()) return std::move(result_);
    result_.model = result_.start.model;
    ReportProgress(progress, 0.6, "adjusting the ring model");
    Adjust(Agreeing(matches, RingSfmTuning::kRawMatch_px), RingSfmTuning::kRawPoint_px);
    for (const double error_px : {RingSfmTuning::kFirstMatch_px, RingSfmTuning::kSecondMatch_px}) {
      ReportProgress(progress, error_px > 3 ? 0.7 : 0.8,
                     "matching along the ring model's epipolar lines");
      Adjust(GuidedMatches(SceneOf(result_.model, names_, {}), error_px), RingSfmTuning::kPoint_px);
    }
    if (bundle_.observations.size() < 3 * result_.model.views.size()) return std::move(result_);
    result_.found = true;
    ReportProgress(progress, 0.9, "adjusting free cameras");
    Release(progress);
    return std::move(result_);
  }

 private:
  void ChooseLayout(const Camera& camera, const std::vector<PairPoints>& points,
                    const std::vector<RingLayout>& layouts, Progress* progress) {
    for (std::size_t k = 0; k < layouts.size(); ++k) {
      const double from = 0.6 * static_cast<double>(k) / static_cast<double>(layouts.size());
      SubProgress part(progress, from, from + 0.6 / static_cast<double>(layouts.size()));
      RingStart start = FindRingModel(camera, layouts[k], points, &part);
      // A wrong layout has a few more matches only because of its additional unknowns.
      if (k > 0 && start.inliers < RingSfmTuning::kBetterLayout * result_.start.inliers) continue;
      result_.start = std::move(start);
      result_.layout = layouts[k];
    }
  }

  std::vector<int> ViewOfImage() const {
    std::vector<int> view_of(names_.size(), -1);
    for (std::size_t v = 0; v < result_.model.views.size(); ++v)
      view_of[result_.model.views[v].image] = static_cast<int>(v);
    return view_of;
  }

  /// The raw matches near the model's epipolar lines.
  std::vector<PairMatches> Agreeing(const std::vector<PairMatches>& matches,
                                    double error_px) const {
    const std::vector<int> view_of = ViewOfImage();
    std::vector<PairMatches> agreeing;
    for (const PairMatches& pair : matches) {
      const int a = view_of[pair.first], b = view_of[pair.second];
      if (a < 0 || b < 0) continue;
      PairMatches kept{pair.first, pair.second, {}};
      for (const int row :
           RingInliers(result_.model, result_.model.views[a], result_.model.views[b],
                       PointsOf({pair}, features_)[0], error_px))
        kept.features.push_back(pair.features[row]);
      if (!kept.features.empty()) agreeing.push_back(std::move(kept));
    }
    return agreeing;
  }

  /// Matches along the epipolar lines of pairs of cameras with similar viewing directions.
  std::vector<PairMatches> GuidedMatches(const Scene& scene, double error_px) const {
    std::vector<std::pair<std::size_t, std::size_t>> pairs;
    for (std::size_t a = 0; a < scene.views.size(); ++a)
      for (std::size_t b = a + 1; b < scene.views.size(); ++b) {
        const Rigid3 turn =
            Compose(scene.views[b].camera_from_world, scene.views[a].camera_from_world.Inverse());
        if ((turn.rotation * Eigen::Vector3d::UnitZ()).z() >
            std::cos(options_.widest_pair_deg * kDegree))
          pairs.emplace_back(a, b);
      }
    std::vector<PairMatches> found(pairs.size());
    ParallelFor(std::ssize(pairs), [&](std::int64_t k) {
      const auto [a, b] = pairs[k];
      const int first = result_.model.views[a].image, second = result_.model.views[b].image;
      PairGeometry geometry;
      geometry.kind = PairGeometry::kFundamental;
      geometry.matrix = FundamentalMatrix(
          scene.views[a].camera,
          Compose(scene.views[b].camera_from_world, scene.views[a].camera_from_world.Inverse()));
      found[k] = {
          first, second,
          MatchGuided(features_[first], features_[second], geometry, options_.matching, error_px)};
    });
    return found;
  }

  Triangulated Points(const Scene& scene, const std::vector<PairMatches>& matches,
                      double error_px) const {
    return Triangulate(scene, ViewOfImage(), BuildTracks(matches, features_), features_,
                       {.min_angle_deg = RingSfmTuning::kLeastAngle_deg, .max_error_px = error_px});
  }

  void Adjust(const std::vector<PairMatches>& matches, double triangulation_error_px) {
    const Triangulated points =
        Points(SceneOf(result_.model, names_, {}), matches, triangulation_error_px);
    RingBundleOptions ring = options_.ring;
    if (ring.focal_px <= 0) ring.focal_px = result_.start.model.camera.fx;
    bundle_ = AdjustRingBundle(result_.model, points.scene.points, points.observations, ring);
    result_.model = bundle_.model;
    result_.ring_error_px = bundle_.mean_error_px;
  }

  void Release(Progress* progress) {
    result_.slop_deg.clear();
    for (const double slop : bundle_.slop_rad) result_.slop_deg.push_back(slop / kDegree);
    const Scene ring = SceneOf(result_.model, names_, bundle_.points);
    BundleOptions ring_camera = options_.bundle;
    ring_camera.max_iterations = 0;  // the ring's own errors, computed in the same way
    BundleResult held = AdjustBundle(ring, bundle_.observations, ring_camera, progress);
    std::vector<int> seen(ring.views.size(), 0);
    for (const Observation& o : bundle_.observations) ++seen[o.view];
    bool all_seen = true;
    for (std::size_t v = 0; v < seen.size(); ++v)
      if (seen[v] < options_.min_view_matches) {
        all_seen = false;
        result_.by_step_only.push_back(ring.views[v].name);
      }
    result_.scene = std::move(held.scene);
    if (!all_seen) return;  // a free camera needs observations
    BundleResult free = AdjustBundle(ring, bundle_.observations, options_.bundle, progress);
    const double observations = 2.0 * static_cast<double>(bundle_.observations.size()),
                 points = 3.0 * static_cast<double>(ring.points.size());
    const double ring_freedom = observations - points - bundle_.unknowns,
                 free_freedom =
                     observations - points - 6.0 * static_cast<double>(ring.views.size()) - 3;
    result_.free_error_px = free.after_px;
    if (ring_freedom <= 0 || free_freedom <= 0 || held.chi2 <= 0) return;
    result_.chi2_ratio = free.chi2 / free_freedom / (held.chi2 / ring_freedom);
    if (result_.chi2_ratio >= options_.release_share) return;
    result_.freed = true;
    Follow(std::move(free.scene), progress);
  }

  /// Matches and adjusts again: matches that did not fit the ring may fit the free cameras.
  void Follow(Scene scene, Progress* progress) {
    for (const double error_px : {RingSfmTuning::kFirstMatch_px, RingSfmTuning::kSecondMatch_px}) {
      const Triangulated points =
          Points(scene, GuidedMatches(scene, error_px), RingSfmTuning::kFreePoint * error_px);
      BundleResult free =
          AdjustBundle(points.scene, points.observations, options_.bundle, progress);
      result_.free_error_px = free.after_px;
      scene = std::move(free.scene);
    }
    result_.scene = std::move(scene);
  }

  const std::vector<std::string>& names_;
  const std::vector<Features>& features_;
  const RingSfmOptions& options_;
  RingSfmResult result_;
  RingBundleResult bundle_;
};

}  // namespace

RingSfmResult ReconstructRing(const Camera& camera, const std::vector<std::string>& names,
                              const std::vector<Features>& features,
                              const std::vector<PairMatches>& matches,
                              const std::vector<RingLayout>& layouts, const RingSfmOptions& options,
                              Progress* progress) {
  return Reconstruction(names, features, options).Run(camera, matches, layouts, progress);
}

}  // namespace keypose::reconstruct
