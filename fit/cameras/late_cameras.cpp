#include "fit/cameras/late_cameras.h"

#include <algorithm>

#include "core/numbers/parallel.h"
#include "core/values/size_of.h"
#include "core/values/tuned.h"
#include "fit/cameras/cameras_around.h"
#include "fit/cameras/candidates.h"

namespace keypose::fit {
namespace {

// Chosen on the photographs of a skull.
struct LateCamerasTuning {
  KEYPOSE_TUNED(double, kLeastMatches, 15);  // that are enough by themselves
  // A few are enough for the camera of a rig whose silhouette overlaps more than all others' by
  // this.
  KEYPOSE_TUNED(double, kFewMatches, 4);
  KEYPOSE_TUNED(double, kMargin, 0.05);
  // A camera of a part that has moved shows the others beside the mask.
  KEYPOSE_TUNED(double, kLeastOverlap, 0.85);
};

/// @param candidates  of a rig, by falling overlap
/// @return nothing if none is sure
const Candidate* BestOfRig(const std::vector<Candidate>& candidates) {
  const Candidate* best = BestOf(candidates);
  if (!best || best->overlap < LateCamerasTuning::kLeastOverlap) return nullptr;
  if (SizeOf(best->matches) >= LateCamerasTuning::kLeastMatches) return best;
  const bool outline_agrees = best == &candidates[0] && SizeOf(candidates) > 1 &&
                              best->overlap > candidates[1].overlap + LateCamerasTuning::kMargin;
  return outline_agrees && SizeOf(best->matches) >= LateCamerasTuning::kFewMatches ? best : nullptr;
}

/// The rig's camera that took the photograph.
bool FindOnRig(const CandidateJudge& judge, const PreparedView& view, const std::vector<View>& rig,
               FoundCamera& camera) {
  const PictureFeatures photo = FeaturesToJudgeBy(view);
  std::vector<Candidate> candidates = judge.OfRig(view, rig);
  ParallelFor(SizeOf(candidates),
              [&](std::int64_t i) { judge.Judge(view, photo, {}, candidates[i]); });
  const Candidate* best = BestOfRig(candidates);
  if (!best) return false;
  camera.found = true;
  camera.camera_from_world = best->camera_from_world;
  camera.matches = camera.agreeing;  // of another part, perhaps, than the nearby ones
  camera.matches.insert(camera.matches.end(), best->matches.begin(), best->matches.end());
  return true;
}

}  // namespace

int FindLateCameras(const Mesh& mesh, const Image8& texture, const std::vector<PreparedView>& views,
                    const std::vector<View>& rig, std::vector<FoundCamera>& cameras,
                    Progress* progress) {
  const CandidateJudge judge(mesh, texture);
  int count = 0;
  for (int v = 0; v < SizeOf(views); ++v) {
    if (cameras[v].found) continue;
    ReportProgress(progress, static_cast<double>(v) / SizeOf(views), "cameras, again");
    count += rig.empty() ? FindAllRound(judge, mesh, views[v], cameras[v])
                         : FindOnRig(judge, views[v], rig, cameras[v]);
  }
  return count;
}

int PlaceByOutlines(const Mesh& mesh, const std::vector<PreparedView>& views,
                    const std::vector<View>& rig, std::vector<FoundCamera>& cameras) {
  struct Pair {
    double overlap;
    int view, of_rig;
  };
  constexpr double kLeastOverlap = 0.5;  // limbs have moved
  const Image8 none;
  const CandidateJudge judge(mesh, none);
  std::vector<Pair> pairs;
  for (int v = 0; v < SizeOf(views); ++v) {
    if (cameras[v].found) continue;
    const std::vector<double> overlaps = judge.Overlaps(views[v], rig);
    for (int i = 0; i < SizeOf(rig); ++i)
      if (overlaps[i] >= kLeastOverlap) pairs.push_back({overlaps[i], v, i});
  }
  std::stable_sort(pairs.begin(), pairs.end(),
                   [](const Pair& a, const Pair& b) { return a.overlap > b.overlap; });
  std::vector<char> taken(rig.size());
  int count = 0;
  for (const Pair& pair : pairs) {
    if (cameras[pair.view].found || taken[pair.of_rig]) continue;
    taken[pair.of_rig] = 1;
    cameras[pair.view].found = true;
    cameras[pair.view].camera_from_world = rig[pair.of_rig].camera_from_world;
    ++count;
  }
  return count;
}

}  // namespace keypose::fit
