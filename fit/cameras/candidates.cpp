#include "fit/cameras/candidates.h"

#include <algorithm>
#include <cmath>

#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"
#include "core/values/size_of.h"
#include "core/values/tuned.h"
#include "fit/bending/feature_filter.h"
#include "fit/bending/nearby_matches.h"
#include "fit/cameras/views_around.h"
#include "views/placement/picture_pose.h"

namespace keypose::fit {
namespace {

// The first was chosen on the photographs of a skull, the others on those of a plush dog.
struct CandidateTuning {
  KEYPOSE_TUNED(double, kReach, 0.06);  // of a match from where the mesh has it, of the longer side
  KEYPOSE_TUNED(double, kWithin, 0.016);  // error of an inlier, of the longer side
  // Power of the overlap in a free camera's score: features of one part alone turn the others out
  // of the mask.
  KEYPOSE_TUNED(double, kOutline, 8);
};

constexpr int kFeaturesToJudgeBy = 4000, kMostOfRig = 10, kMostAround = 24;
constexpr int kLeastFromAnywhere = 12;  // of a camera by features from anywhere
constexpr int kLeastNearby = 6;         // by nearby ones

double Longer(const Pinhole& camera) { return std::max(camera.width, camera.height); }

}  // namespace

std::vector<FeatureMatch> Candidate::MatchesAndPicks() const {
  std::vector<FeatureMatch> all = matches;
  all.insert(all.end(), picks.begin(), picks.end());
  return all;
}

const Candidate* BestOf(const std::vector<Candidate>& candidates) {
  const Candidate* best = nullptr;
  for (const Candidate& candidate : candidates)
    if (!best || candidate.score > best->score) best = &candidate;
  return best;
}

PictureFeatures FeaturesToJudgeBy(const PreparedView& view) {
  return FindFeatures(view.color, MaskOf(view), kFeaturesToJudgeBy);
}

double Reach(const Pinhole& camera) { return CandidateTuning::kReach * Longer(camera); }

std::vector<FeatureMatch> NearMatches(const Candidate& candidate, const PointsX3& points,
                                      const Pinhole& camera,
                                      const std::vector<FeatureMatch>& matches) {
  std::vector<FeatureMatch> near;
  for (const FeatureMatch& match : matches) {
    const Eigen::Vector3d x = candidate.camera_from_world * PositionOf(match.point, points);
    if (x.z() > 0 && (camera.Project(x) - match.pixel).norm() < Reach(camera))
      near.push_back(match);
  }
  return near;
}

CandidateJudge::CandidateJudge(const Mesh& mesh, const Image8& texture)
    : mesh_(mesh),
      picture_(texture),
      texture_(mesh, texture),
      scene_(mesh.points, mesh.faces),
      area_(SurfaceArea(mesh.points, mesh.faces)) {}

TexturedRender CandidateJudge::RenderAt(const PreparedView& view, int level,
                                        const Rigid3& pose) const {
  const double footprint = pose.translation.norm() / view.camera(level).fx;
  return RenderGrey(mesh_.points, mesh_.faces, texture_, texture_.LevelFor(area_, footprint),
                    scene_, view.camera(level), pose);
}

std::vector<double> CandidateJudge::Overlaps(const PreparedView& view,
                                             const std::vector<View>& rig) const {
  std::vector<double> overlaps(rig.size());
  const int coarsest = SizeOf(view.levels) - 1;
  ParallelFor(SizeOf(rig), [&](std::int64_t i) {
    overlaps[i] =
        Overlap(RenderAt(view, coarsest, rig[i].camera_from_world), view.levels[coarsest].grey);
  });
  return overlaps;
}

std::vector<Candidate> CandidateJudge::OfRig(const PreparedView& view,
                                             const std::vector<View>& rig) const {
  const std::vector<double> overlaps = Overlaps(view, rig);
  std::vector<Candidate> candidates(rig.size());
  for (int i = 0; i < SizeOf(rig); ++i) {
    candidates[i].camera_from_world = rig[i].camera_from_world;
    candidates[i].overlap = overlaps[i];
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const auto& a, const auto& b) { return a.overlap > b.overlap; });
  candidates.resize(std::min<std::size_t>(candidates.size(), kMostOfRig));
  return candidates;
}

std::vector<Candidate> CandidateJudge::AllRound(const PreparedView& view,
                                                const std::vector<FeatureMatch>& matches) const {
  std::vector<Candidate> candidates;
  for (const ViewAround& around : ViewsAround(mesh_, picture_, scene_, view, kMostAround))
    candidates.push_back({around.camera_from_world, true, around.overlap});
  const double within = CandidateTuning::kWithin / 2 * Longer(view.camera());
  const PicturePose pose =
      PlacePicture(view.camera(), mesh_.points, matches, within, kLeastFromAnywhere);
  if (pose.found) candidates.push_back({pose.camera_from_world, true});
  return candidates;
}

void CandidateJudge::Judge(const PreparedView& view, const PictureFeatures& photo,
                           const std::vector<FeatureMatch>& picks, Candidate& candidate) const {
  const FitView at{0, view.camera(), candidate.camera_from_world};
  const double reach = Reach(at.camera);
  const TexturedRender render = RenderAt(view, 0, candidate.camera_from_world);
  candidate.overlap = Overlap(render, view.levels[0].grey);
  const std::vector<FeatureMatch> found =
      MatchNearby(mesh_.faces, scene_, render, at, photo, reach);
  candidate.matches =
      NearbyMatches(mesh_.points, mesh_.points, found, at.camera, candidate.camera_from_world);
  candidate.picks = NearMatches(candidate, mesh_.points, at.camera, picks);
  candidate.score = 0;
  for (const FeatureMatch& match : candidate.MatchesAndPicks()) {
    const Eigen::Vector2d shown =
        at.camera.Project(candidate.camera_from_world * PositionOf(match.point, mesh_.points));
    candidate.score += 1 - (match.pixel - shown).norm() / reach;
  }
  if (candidate.free) candidate.score *= std::pow(candidate.overlap, CandidateTuning::kOutline);
}

void CandidateJudge::Improve(const PreparedView& view, const PictureFeatures& photo,
                             const std::vector<FeatureMatch>& picks, Candidate& candidate) const {
  constexpr int kRounds = 3;
  const double within = CandidateTuning::kWithin * Longer(view.camera());
  for (int round = 0; round < kRounds; ++round) {
    const PicturePose pose = PlacePicture(view.camera(), mesh_.points, candidate.MatchesAndPicks(),
                                          within, kLeastNearby);
    if (!pose.found) return;
    Candidate next{pose.camera_from_world, candidate.free};
    Judge(view, photo, picks, next);
    if (next.score <= candidate.score) return;
    candidate = next;
  }
}

}  // namespace keypose::fit
