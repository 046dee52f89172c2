#include "fit/bending/patch_matches.h"

#include "core/values/size_of.h"

namespace keypose::fit {
namespace {

PatchPictures PicturesOf(const PatchView& view) {
  return {view.render, view.photo, view.mask, view.view.camera.fx};
}

}  // namespace

std::vector<FeatureMatch> MatchPatches(const std::vector<SeenVertex>& seen, const PointsX3& points,
                                       const PatchView& fine, const PatchView& coarse,
                                       const Pinhole& whole, double reach) {
  std::vector<SeenVertex> seen_coarsely = seen;
  for (SeenVertex& one : seen_coarsely)
    one.pixel = coarse.view.camera.Project(coarse.view.camera_from_world *
                                           points.row(one.vertex).transpose());
  PatchSearch search;
  search.reach_px =
      reach * coarse.view.camera.fx / coarse.view.camera_from_world.translation.norm();
  const std::vector<FoundPatch> found = RefinePatches(
      seen, SearchPatches(seen_coarsely, PicturesOf(coarse), search), PicturesOf(fine), search);
  std::vector<FeatureMatch> matches;
  for (int i = 0; i < SizeOf(seen); ++i) {
    if (!found[i].found) continue;
    const Eigen::Vector2d goal = seen[i].pixel + found[i].shift;
    matches.push_back({{Eigen::Vector3i::Constant(seen[i].vertex), Eigen::Vector3d::UnitX()},
                       whole.Project(fine.view.camera.Ray(goal.x(), goal.y())),
                       found[i].correlation,
                       0});
  }
  return matches;
}

}  // namespace keypose::fit
