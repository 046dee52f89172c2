#include "fit/cameras/late_cameras.h"

#include <algorithm>

#include "core/geometry.h"
#include "core/parallel.h"
#include "core/ray_scene.h"
#include "core/size_of.h"
#include "core/tuned.h"
#include "fit/appearance/textured_render.h"
#include "fit/bending/feature_filter.h"
#include "fit/bending/nearby_matches.h"
#include "views/placement/picture_pose.h"

namespace keypose::fit {
namespace {

// Chosen on the photographs of a skull.
struct LateCamerasTuning {
  KEYPOSE_TUNED(double, kReach, 0.06);  // of a match from where the mesh has it, of the longer side
  KEYPOSE_TUNED(double, kWithin, 0.008);     // of an inlier of a camera without a rig
  KEYPOSE_TUNED(double, kLeastMatches, 15);  // that are enough by themselves
  // A few are enough for the camera of a rig whose silhouette overlaps more than all others' by
  // this.
  KEYPOSE_TUNED(double, kFewMatches, 4);
  KEYPOSE_TUNED(double, kMargin, 0.05);
  // A camera of a part that has moved shows the others beside the mask.
  KEYPOSE_TUNED(double, kLeastOverlap, 0.85);
};

constexpr int kLateFeatures = 4000, kLateInliers = 12, kMostCandidates = 10;

struct Candidate {
  Rigid3 camera_from_world;
  double overlap = 0;                 // of silhouette and mask
  std::vector<FeatureMatch> matches;  // nearby
  double score = 0;                   // matches, the nearer the more
};

class Search {
 public:
  Search(const Mesh& mesh, const Image8& texture)
      : mesh_(mesh),
        texture_(mesh, texture),
        scene_(mesh.points, mesh.faces),
        area_(SurfaceArea(mesh.points, mesh.faces)) {}

  /// Of the silhouettes under the rig's cameras with the mask, at the coarsest level.
  std::vector<double> Overlaps(const PreparedView& view, const std::vector<View>& rig) const {
    std::vector<double> overlaps(rig.size());
    const int coarsest = SizeOf(view.levels) - 1;
    ParallelFor(SizeOf(rig), [&](std::int64_t i) {
      overlaps[i] =
          Overlap(RenderAt(view, coarsest, rig[i].camera_from_world), view.levels[coarsest].grey);
    });
    return overlaps;
  }

  /// The rig's cameras whose silhouettes overlap most with the mask.
  std::vector<Candidate> OfRig(const PreparedView& view, const std::vector<View>& rig) const {
    const std::vector<double> overlaps = Overlaps(view, rig);
    std::vector<Candidate> candidates(rig.size());
    for (int i = 0; i < SizeOf(rig); ++i) {
      candidates[i].camera_from_world = rig[i].camera_from_world;
      candidates[i].overlap = overlaps[i];
    }
    std::stable_sort(candidates.begin(), candidates.end(),
                     [](const auto& a, const auto& b) { return a.overlap > b.overlap; });
    candidates.resize(std::min<std::size_t>(candidates.size(), kMostCandidates));
    return candidates;
  }
  void Judge(const PreparedView& view, const PictureFeatures& photo, Candidate& candidate) const;
  const RayScene& scene() const { return scene_; }

 private:
  TexturedRender RenderAt(const PreparedView& view, int level, const Rigid3& pose) const {
    const double footprint = pose.translation.norm() / view.camera(level).fx;
    return RenderGrey(mesh_.points, mesh_.faces, texture_, texture_.LevelFor(area_, footprint),
                      scene_, view.camera(level), pose);
  }

  const Mesh& mesh_;
  SurfaceTexture texture_;
  RayScene scene_;
  double area_;
};

void Search::Judge(const PreparedView& view, const PictureFeatures& photo,
                   Candidate& candidate) const {
  const FitView at{0, view.camera(), candidate.camera_from_world};
  const double reach = LateCamerasTuning::kReach * std::max(at.camera.width, at.camera.height);
  const TexturedRender render = RenderAt(view, 0, candidate.camera_from_world);
  candidate.overlap = Overlap(render, view.levels[0].grey);
  const std::vector<FeatureMatch> found =
      MatchNearby(mesh_.faces, scene_, render, at, photo, reach);
  candidate.matches =
      NearbyMatches(mesh_.points, mesh_.points, found, at.camera, candidate.camera_from_world);
  for (const FeatureMatch& match : candidate.matches) {
    const Eigen::Vector2d shown =
        at.camera.Project(candidate.camera_from_world * PositionOf(match.point, mesh_.points));
    candidate.score += 1 - (match.pixel - shown).norm() / reach;
  }
}

/// The camera of a photograph by its features on the bent mesh.
std::vector<Candidate> Alone(const Mesh& mesh, const PreparedView& view,
                             const FoundCamera& camera) {
  const double within =
      LateCamerasTuning::kWithin * std::max(view.camera().width, view.camera().height);
  const PicturePose pose =
      PlacePicture(view.camera(), mesh.points, camera.matches, within, kLateInliers);
  std::vector<Candidate> candidates;
  if (pose.found) candidates.push_back({pose.camera_from_world, 0, {}, 0});
  return candidates;
}

/// @param candidates  those of a rig by falling overlap
/// @return nothing if none is sure
const Candidate* BestOf(const std::vector<Candidate>& candidates) {
  const Candidate* best = nullptr;
  for (const Candidate& candidate : candidates)
    if (!best || candidate.score > best->score) best = &candidate;
  if (!best || best->overlap < LateCamerasTuning::kLeastOverlap) return nullptr;
  if (SizeOf(best->matches) >= LateCamerasTuning::kLeastMatches) return best;
  const bool outline_agrees = best == &candidates[0] && SizeOf(candidates) > 1 &&
                              best->overlap > candidates[1].overlap + LateCamerasTuning::kMargin;
  return outline_agrees && SizeOf(best->matches) >= LateCamerasTuning::kFewMatches ? best : nullptr;
}

}  // namespace

int FindLateCameras(const Mesh& mesh, const Image8& texture, const std::vector<PreparedView>& views,
                    const std::vector<View>& rig, std::vector<FoundCamera>& cameras,
                    Progress* progress) {
  const Search search(mesh, texture);
  int count = 0;
  for (int v = 0; v < SizeOf(views); ++v) {
    FoundCamera& camera = cameras[v];
    if (camera.found) continue;
    ReportProgress(progress, static_cast<double>(v) / SizeOf(views), "cameras, again");
    const PictureFeatures photo = FindFeatures(views[v].color, MaskOf(views[v]), kLateFeatures);
    std::vector<Candidate> candidates =
        rig.empty() ? Alone(mesh, views[v], camera) : search.OfRig(views[v], rig);
    ParallelFor(SizeOf(candidates),
                [&](std::int64_t i) { search.Judge(views[v], photo, candidates[i]); });
    const Candidate* best = BestOf(candidates);
    if (!best) continue;
    camera.found = true;
    camera.camera_from_world = best->camera_from_world;
    camera.matches = camera.agreeing;  // of another part, perhaps, than the nearby ones
    camera.matches.insert(camera.matches.end(), best->matches.begin(), best->matches.end());
    ++count;
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
  const Search search(mesh, {});
  std::vector<Pair> pairs;
  for (int v = 0; v < SizeOf(views); ++v) {
    if (cameras[v].found) continue;
    const std::vector<double> overlaps = search.Overlaps(views[v], rig);
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
