#include "reconstruct/sfm/strategy.h"

#include <algorithm>
#include <utility>

#include "core/io/pictures/image_set.h"

namespace keypose::reconstruct {
namespace {

/// Evenly spread over the list, for a quick check.
Scene SomeViews(const Scene& scene, std::size_t most) {
  if (scene.views.size() <= most) return scene;
  Scene some;
  for (std::size_t k = 0; k < most; ++k)
    some.views.push_back(scene.views[k * scene.views.size() / most]);
  return some;
}

}  // namespace

StrategyResult StrategyContext::WithEvidence(StrategyResult result,
                                             const MatchedFeatures& matched) const {
  constexpr std::size_t kMostViews = 32;
  const Scene some = SomeViews(result.model.scene, kMostViews);
  result.evidence = matched.in_room ? check.EvaluateSurroundings(result.model.scene,
                                                                 matched.features, matched.verified)
                                    : check.Evaluate(some, matched.features, matched.verified);
  result.evidence.placed = static_cast<int>(result.views());
  return result;
}

bool StrategyContext::IsSettled(const StrategyResult& result) const {
  if (result.views() < set.images.size()) return false;
  return result.model.scale_source != "none" || IsSure(result.evidence);
}

StrategyResult BetterOf(StrategyResult best, StrategyResult candidate) {
  return IsBetter(candidate.evidence, best.evidence) ? std::move(candidate) : std::move(best);
}

std::vector<double> FocalsToTry(const MatchedFeatures& matched) {
  if (matched.focal_known) return {matched.camera.fx};
  const double side = std::max(matched.camera.width, matched.camera.height);
  std::vector<double> focals;
  for (const double times : {1.2, 1.45, 1.75, 1.0, 2.1, 0.85, 2.55}) focals.push_back(times * side);
  focals[0] = matched.camera.fx;
  return focals;
}

Camera WithFocal(Camera camera, double focal_px) {
  camera.fx = camera.fy = focal_px;
  return camera;
}

std::vector<Camera> WithFocal(std::vector<Camera> cameras, double focal_px) {
  const double factor = focal_px / cameras.front().fx;
  for (Camera& camera : cameras) camera = WithFocal(camera, factor * camera.fx);
  return cameras;
}

}  // namespace keypose::reconstruct
