#include "composite/locating/search/find_place.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "composite/locating/candidates/shape_search.h"
#include "composite/locating/outline/shrunk.h"
#include "core/numbers/parallel.h"
#include "core/numbers/rotations.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "core/values/tuned.h"

namespace keypose::composite {
namespace {

// Chosen on the clay creature's seeds 1 to 4 (synth).
struct SearchTuning {
  KEYPOSE_TUNED(int, kRoughCandidates, 36);
  KEYPOSE_TUNED(int, kFineCandidates, 6);
  KEYPOSE_TUNED(double, kReach, 0.09);     // of the rough fit's first round, of the longer side
  KEYPOSE_TUNED(double, kGreyScore, 4);    // px of outline that a correlation of 0 costs
  KEYPOSE_TUNED(double, kMoreFocals, 12);  // candidates for which other focal lengths are tried
  // px of outline, at 960, from which on a place is doubted and others are looked for; chosen on
  // 102 photographs of a plush dog.
  KEYPOSE_TUNED(double, kDoubted, 2);
};

constexpr int kRoughVertices = 3000, kRoughSide = 480, kFineSide = 960, kShapeSide = 240;
constexpr double kScoreReach = 12, kRoughReach = 3;  // px
constexpr double kSame = 0.1;                        // rad between places that are one
constexpr double kLeastMatte = 5e-4;                 // of the picture
const std::vector<double> kOtherFocals{1, 0.6, 1.7};

struct Trial {
  Placement at;
  double score = 1e300;  // px
  double outline_px = 1e300;
};

Image8 ShrunkTo(const Image8& picture, int side) {
  const double scale =
      std::min(1.0, static_cast<double>(side) / std::max(picture.width, picture.height));
  return Shrunk(picture, std::max(1, static_cast<int>(std::lround(picture.width * scale))),
                std::max(1, static_cast<int>(std::lround(picture.height * scale))));
}

Camera CameraFor(const Camera& camera, const Image8& picture) {
  Camera scaled = camera.Scaled(static_cast<double>(picture.width) / camera.width);
  scaled.width = picture.width;
  scaled.height = picture.height;
  return scaled;
}

/// A trial's score: outlines, and with a texture how well grey values agree.
void Score(Trial& trial, const Figure& figure, const PictureEvidence& evidence, const Look& look) {
  const Placement scaled = trial.at.Scaled(evidence.scale);
  trial.outline_px = MatchOutlines(FindSilhouette(figure, scaled, 2), evidence.outline, kScoreReach)
                         .Mean(kScoreReach);
  trial.score = trial.outline_px;
  for (const Click& click : evidence.clicks)
    trial.score += (click.pixel - scaled.Project(PositionOf(click.point, figure.points))).norm() /
                   SizeOf(evidence.clicks);
  if (look.texture)
    trial.score +=
        SearchTuning::kGreyScore *
        (1 - MatchGreys(figure, *look.texture, evidence.luma, evidence.matte, scaled).correlation);
}

void SortTrials(std::vector<Trial>& trials) {
  std::stable_sort(trials.begin(), trials.end(),
                   [](const Trial& a, const Trial& b) { return a.score < b.score; });
}

bool SeenAlike(const Placement& a, const Placement& b) {
  return RotationDifference(a.camera_from_mesh.rotation, b.camera_from_mesh.rotation) <
         std::pow(std::sin(kSame / 2), 2);
}

/// Drops trials that have arrived where a better one is; sorted.
std::vector<Trial> Different(std::vector<Trial> trials, int most) {
  SortTrials(trials);
  std::vector<Trial> kept;
  for (const Trial& trial : trials) {
    if (SizeOf(kept) >= most) break;
    if (std::none_of(kept.begin(), kept.end(),
                     [&](const Trial& other) { return SeenAlike(trial.at, other.at); }))
      kept.push_back(trial);
  }
  return kept;
}

/// Each start refined at 480 px on the rough mesh.
void RefineRoughly(std::vector<Trial>& trials, const PosedFigure& figure,
                   const PictureEvidence& evidence) {
  const double side = std::max(evidence.matte.width, evidence.matte.height);
  const Figure& rough = figure.rough();
  ParallelFor(SizeOf(trials), [&](std::int64_t i) {
    const RefineStep step{SearchTuning::kReach * side, kRoughReach, 12};
    trials[i].at = Refined(rough, evidence, trials[i].at, step, {});
    Score(trials[i], rough, evidence, {});
  });
}

/// Focal length and depth change a silhouette nearly alike: other focal lengths are other starts.
std::vector<Trial> WithOtherFocals(const std::vector<Trial>& trials, const Figure& figure) {
  std::vector<Trial> more;
  for (int i = 0; i < std::min<int>(SearchTuning::kMoreFocals, SizeOf(trials)); ++i)
    for (int k = 1; k < SizeOf(kOtherFocals); ++k) {
      const double focal = trials[i].at.camera.fx * kOtherFocals[k];
      more.push_back({WithFocal(trials[i].at, focal, figure.center)});
    }
  return more;
}

/// The best trials refined at 960 px on the whole mesh.
/// @param sightings  which all trials shall agree with; may be empty
void RefineFinely(std::vector<Trial>& trials, const PosedFigure& figure, const LocateFrame& frame,
                  const Look& look, bool focal_known, const std::vector<Sighting>& sightings = {}) {
  const double scale = std::min(
      1.0, static_cast<double>(kFineSide) / std::max(frame.picture.width, frame.picture.height));
  PictureEvidence evidence =
      MakeEvidence(frame.picture, frame.matte, frame.matte_deviation_px, scale);
  SetClicks(evidence, frame.clicks);
  SetSightings(evidence, sightings);
  ParallelFor(SizeOf(trials), [&](std::int64_t i) {
    LensPrior lens;
    lens.focal_free = !focal_known;
    lens.focal_px = trials[i].at.camera.fx;
    lens.focal_deviation = 0.2;
    trials[i].at = Refined(figure.fine, evidence, trials[i].at, {12, 2.5, 8}, lens);
    Score(trials[i], figure.fine, evidence, look);
  });
  SortTrials(trials);
}

FoundPlace PlaceByOutlines(const PosedFigure& figure, const LocateFrame& frame, const Look& look,
                           const Camera& camera, bool focal_known) {
  const Image8 small = ShrunkTo(frame.matte, kShapeSide);
  const Camera small_camera = CameraFor(camera, small);
  const ShapeSearch search(figure.rough(), AngularRadius(small_camera, small));
  std::vector<Trial> trials;
  for (const ShapeCandidate& candidate :
       search.Find(small_camera, small, SearchTuning::kRoughCandidates))
    trials.push_back({{camera, candidate.camera_from_mesh}});
  const double scale = std::min(
      1.0, static_cast<double>(kRoughSide) / std::max(frame.picture.width, frame.picture.height));
  PictureEvidence evidence =
      MakeEvidence(frame.picture, frame.matte, frame.matte_deviation_px, scale);
  SetClicks(evidence, frame.clicks);
  RefineRoughly(trials, figure, evidence);
  SortTrials(trials);
  if (!focal_known) {
    std::vector<Trial> more = WithOtherFocals(trials, figure.fine);
    RefineRoughly(more, figure, evidence);
    trials.insert(trials.end(), more.begin(), more.end());
  }
  trials = Different(std::move(trials), SearchTuning::kFineCandidates);
  RefineFinely(trials, figure, frame, look, focal_known);
  FoundPlace found{trials[0].at, "outlines", {}, 0, trials[0].score};
  for (const Trial& trial : trials)
    if (!SeenAlike(trial.at, trials[0].at)) {
      found.rival_ratio = trial.score / std::max(trials[0].score, 1e-3);
      break;
    }
  return found;
}

std::optional<FoundPlace> ByFeatures(const PosedFigure& figure, const LocateFrame& frame,
                                     const Look& look, const Camera& camera, bool focal_known) {
  std::vector<double> factors{1};
  if (!focal_known) factors = {0.48, 0.56, 0.7, 1, 1.4, 1.7, 2.1, 2.7};
  const std::optional<FeatureCandidate> best = PlaceByFeatures(
      *look.features, figure.fine.points, frame.picture, frame.matte, camera, factors);
  if (!best) return {};
  FoundPlace found{best->placement, "features", best->inliers, 0};
  found.at = RefinedBySightings(found.at, figure.fine.points, found.sightings, 3,
                                figure.fine.center, figure.fine.radius, !focal_known, 15);
  return found;
}

/// A place refined by outlines, with its score.
struct Judged {
  FoundPlace place;
  double outline_px = 1e300;
};
Judged JudgedByOutlines(const FoundPlace& place, const PosedFigure& figure,
                        const LocateFrame& frame, const Look& look, bool focal_known) {
  std::vector<Trial> trials{{place.at}};
  RefineFinely(trials, figure, frame, look, focal_known, place.sightings);
  Judged judged{place, trials[0].outline_px};
  judged.place.at = trials[0].at;
  judged.place.score = trials[0].score;
  return judged;
}

/// The better of features and of where the figure was before; if outlines contradict it, the best
/// of a search by them too. Features of a wrong side agree now and then, and so does a place that
/// was followed.
FoundPlace Best(const std::optional<FoundPlace>& by_features, const FoundPlace* before,
                const PosedFigure& figure, const LocateFrame& frame, const Look& look,
                const Camera& camera, bool focal_known) {
  std::optional<Judged> best;
  if (by_features) best = JudgedByOutlines(*by_features, figure, frame, look, focal_known);
  if (before) {
    const Judged followed = JudgedByOutlines(*before, figure, frame, look, focal_known);
    if (!best || followed.place.score < best->place.score) {
      // Seen alike, both are one place, which the features show as well.
      const bool one = best && SeenAlike(best->place.at, followed.place.at);
      const std::vector<Sighting> sightings =
          one ? best->place.sightings : followed.place.sightings;
      best = followed;
      best->place.sightings = sightings;
    }
  }
  if (best && best->outline_px <= SearchTuning::kDoubted) return best->place;
  const FoundPlace by_outlines = PlaceByOutlines(figure, frame, look, camera, focal_known);
  return best && best->place.score <= by_outlines.score ? best->place : by_outlines;
}

std::string Advice(const LocateFrame& frame) {
  return frame.matte.empty()
             ? "pass --matte or --background (the set without the character), or at least 4 "
               "--clicks"
             : "check that the matte shows this character in this pose, or pass --clicks";
}

}  // namespace

const Figure& PosedFigure::rough() const {
  if (!rough_)
    rough_ = std::make_unique<Figure>(Simplified(fine.points, fine.faces, kRoughVertices));
  return *rough_;
}

std::vector<double> SearchScales(int width, int height) {
  std::vector<double> scales;
  const double side = std::max(width, height);
  for (const int size : {kRoughSide, kFineSide})
    if (size < 0.8 * side) scales.push_back(size / side);
  scales.push_back(1);
  return scales;
}

FoundPlace FindPlace(const PosedFigure& figure, const LocateFrame& frame, const Look& look,
                     const Camera& camera, bool focal_known, const FoundPlace* before) {
  if (SizeOf(frame.clicks) >= 4)
    return {PlaceByClicks(camera, figure.fine.points, frame.clicks, !focal_known), "clicks", {}, 0};
  std::optional<FoundPlace> by_features;
  if (look.features) by_features = ByFeatures(figure, frame, look, camera, focal_known);
  if (!frame.matte.empty() && MatteShare(frame.matte) >= kLeastMatte)
    return Best(by_features, before, figure, frame, look, camera, focal_known);
  if (by_features) return *by_features;
  const char* why = look.features ? "too few features of its picture are those of the texture"
                                  : "there is neither a texture nor a matte to find it by";
  if (!frame.matte.empty()) why = "its matte is empty";
  throw InputError(
      fmt::format("locate: no character found in {}: {}; {}", frame.name, why, Advice(frame)));
}

}  // namespace keypose::composite
