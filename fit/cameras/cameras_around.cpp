#include "fit/cameras/cameras_around.h"

#include <algorithm>

#include "core/parallel.h"
#include "core/size_of.h"
#include "core/tuned.h"

namespace keypose::fit {
namespace {

// Chosen on the photographs of a plush dog and a skull.
struct CamerasAroundTuning {
  KEYPOSE_TUNED(double, kLeastMatches, 12);
  // A camera of a part that has moved shows the others beside the mask: the overlap is at least
  // this, or nearly that of the candidate that overlaps most.
  KEYPOSE_TUNED(double, kLeastOverlap, 0.85);
  KEYPOSE_TUNED(double, kNearlyMost, 0.1);
};

bool IsSure(const Candidate& best, const std::vector<Candidate>& candidates) {
  double most = 0;
  for (const Candidate& candidate : candidates) most = std::max(most, candidate.overlap);
  const double least =
      std::min(CamerasAroundTuning::kLeastOverlap, most - CamerasAroundTuning::kNearlyMost);
  return best.overlap >= least && SizeOf(best.matches) >= CamerasAroundTuning::kLeastMatches;
}

/// Of the photograph's own matches, those near where the camera shows their places; then the
/// nearby ones.
std::vector<FeatureMatch> MatchesUnder(const Candidate& candidate, const Mesh& mesh,
                                       const Pinhole& camera,
                                       const std::vector<FeatureMatch>& own) {
  std::vector<FeatureMatch> matches;
  for (const FeatureMatch& match : own) {
    const Eigen::Vector3d x = candidate.camera_from_world * PositionOf(match.point, mesh.points);
    if (x.z() > 0 && (camera.Project(x) - match.pixel).norm() < Reach(camera))
      matches.push_back(match);
  }
  matches.insert(matches.end(), candidate.matches.begin(), candidate.matches.end());
  return matches;
}

}  // namespace

bool FindAllRound(const CandidateJudge& judge, const Mesh& mesh, const PreparedView& view,
                  FoundCamera& camera) {
  const PictureFeatures photo = FeaturesToJudgeBy(view);
  std::vector<Candidate> candidates = judge.AllRound(view, camera.matches);
  ParallelFor(SizeOf(candidates), [&](std::int64_t i) {
    judge.Judge(view, photo, candidates[i]);
    judge.Improve(view, photo, candidates[i]);
  });
  const Candidate* best = BestOf(candidates);
  if (!best || !IsSure(*best, candidates)) return false;
  camera.found = true;
  camera.camera_from_world = best->camera_from_world;
  camera.matches = MatchesUnder(*best, mesh, view.camera(), camera.matches);
  camera.agreeing = best->matches;
  camera.inliers = SizeOf(best->matches);
  return true;
}

std::vector<FoundCamera> FindCamerasAround(const Mesh& mesh, const Image8& texture,
                                           const std::vector<PreparedView>& views,
                                           std::vector<FoundCamera> cameras, Progress* progress) {
  const CandidateJudge judge(mesh, texture);
  for (int v = 0; v < SizeOf(views); ++v) {
    ReportProgress(progress, static_cast<double>(v) / SizeOf(views), "cameras, from all sides");
    cameras[v].found = FindAllRound(judge, mesh, views[v], cameras[v]);
  }
  return cameras;
}

}  // namespace keypose::fit
