#include "fit/cameras/cameras_around.h"

#include <algorithm>

#include "core/numbers/parallel.h"
#include "core/values/size_of.h"
#include "core/values/tuned.h"

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
  return best.overlap >= least &&
         SizeOf(best.MatchesAndPicks()) >= CamerasAroundTuning::kLeastMatches;
}

}  // namespace

bool FindAllRound(const CandidateJudge& judge, const Mesh& mesh, const PreparedView& view,
                  FoundCamera& camera) {
  const PictureFeatures photo = FeaturesToJudgeBy(view);
  std::vector<Candidate> candidates = judge.AllRound(view, AllMatches(camera));
  const std::vector<FeatureMatch> picks = CountedPicks(camera);
  ParallelFor(SizeOf(candidates), [&](std::int64_t i) {
    judge.Judge(view, photo, picks, candidates[i]);
    judge.Improve(view, photo, picks, candidates[i]);
  });
  const Candidate* best = BestOf(candidates);
  if (!best || !IsSure(*best, candidates)) return false;
  camera.found = true;
  camera.camera_from_world = best->camera_from_world;
  camera.matches = NearMatches(*best, mesh.points, view.camera(), camera.matches);
  camera.matches.insert(camera.matches.end(), best->matches.begin(), best->matches.end());
  camera.agreeing = best->MatchesAndPicks();
  camera.inliers = SizeOf(camera.agreeing);
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
