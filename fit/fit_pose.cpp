#include "fit/fit_pose.h"

#include <algorithm>

#include "fit/cameras/late_cameras.h"

namespace keypose::fit {
namespace {

// How firmly a rig's cameras hold against the photographs: a table that is turned by hand stops a
// degree beside its mark.
constexpr double kHoldRig = 2;

std::vector<BendView> WithCameras(const std::vector<PreparedView>& views,
                                  const std::vector<FoundCamera>& cameras) {
  std::vector<BendView> placed;
  for (int v = 0; v < SizeOf(views); ++v) {
    if (!cameras[v].found) continue;
    placed.push_back({views[v], cameras[v].matches});
    placed.back().view.camera_from_world = cameras[v].camera_from_world;
  }
  return placed;
}

/// Where photographs have no camera: bends the template to nearly the pose by the others, and looks
/// again; once more for each that this finds, since it shows a further part.
/// @return how many it found; nothing if none was looked for
std::optional<int> PlaceLate(const FitInput& in, double hold, std::vector<FoundCamera>& cameras,
                             Progress* progress) {
  constexpr int kFewest = 2;
  if (in.texture.empty()) return {};
  BendOptions options;
  options.only_far = true;
  options.hold_cameras = hold;
  std::optional<int> late;
  for (int found = 1; found > 0;) {
    const std::vector<BendView> placed = WithCameras(in.views, cameras);
    if (SizeOf(placed) == SizeOf(in.views) || SizeOf(placed) < kFewest) break;
    SubProgress bending(progress, 0, 0.6), finding(progress, 0.6, 1);
    const BendMarks marks = MarksOf(in.picks, placed, in.unplaced, nullptr);
    const BendResult nearly =
        BendToViews(in.mesh, in.texture, in.stiffness, placed, marks, options, &bending);
    Mesh bent = in.mesh;
    bent.points = nearly.points;
    for (int v = 0, p = 0; v < SizeOf(in.views); ++v)
      if (cameras[v].found) cameras[v].camera_from_world = nearly.cameras[p++];
    found = FindLateCameras(bent, in.texture, in.views, in.rig, cameras, &finding);
    late = late.value_or(0) + found;
  }
  return late;
}

/// Without a result if fewer than two photographs are placed.
Attempt Try(const FitInput& in, std::vector<FoundCamera> cameras, double hold, Progress* progress) {
  Attempt attempt;
  SubProgress placing(progress, 0, 0.08), bending(progress, 0.08, 1);
  attempt.late = PlaceLate(in, hold, cameras, &placing);
  attempt.placed = WithCameras(in.views, cameras);
  attempt.cameras = std::move(cameras);
  if (SizeOf(attempt.placed) < 2) return attempt;
  attempt.marks = MarksOf(in.picks, attempt.placed, in.unplaced, nullptr);
  BendOptions options;
  options.hold_cameras = hold;
  attempt.result = BendToViews(in.mesh, in.texture, in.stiffness, attempt.placed, attempt.marks,
                               options, &bending);
  return attempt;
}

Attempt TryWithoutRig(const FitInput& in, const std::vector<FoundCamera>& cameras,
                      Progress* progress) {
  std::vector<FoundCamera> sure = cameras;
  const bool doubtful = KeepSureCameras(sure);
  SubProgress first(progress, 0, doubtful ? 0.5 : 1), second(progress, 0.5, 1);
  Attempt all = Try(in, cameras, 0, &first);
  if (!doubtful) return all;
  constexpr double kClearly = 0.01;  // of the overlap with the masks
  Attempt held = Try(in, sure, kHoldRig, &second);
  held.doubtful_dropped = held.Overlap() > all.Overlap() + kClearly;
  all.doubtful_dropped = false;
  return *held.doubtful_dropped ? std::move(held) : std::move(all);
}

}  // namespace

Eigen::Vector2d PreparedPixel(const PreparedView& view, const Scene& scene,
                              const Eigen::Vector2d& pixel) {
  return view.camera().Project(scene.views[view.scene_index].camera.Unproject(pixel));
}

BendMarks MarksOf(const PosePicks& picks, const std::vector<BendView>& views, const Scene& scene,
                  std::vector<std::string>* lost) {
  BendMarks marks;
  for (const PhotoPick& pick : picks.pixels) {
    const auto view = std::find_if(views.begin(), views.end(), [&](const BendView& one) {
      return one.view.scene_index == pick.image;
    });
    if (view != views.end())
      marks.pixels.push_back({pick.name, pick.point, static_cast<int>(view - views.begin()),
                              PreparedPixel(view->view, scene, pick.pixel)});
    else if (lost)
      lost->push_back("'" + pick.name + "' in " + scene.views[pick.image].name);
  }
  marks.places = picks.places;
  return marks;
}

Attempt FitPose(const FitInput& in, const std::vector<FoundCamera>& cameras, bool by_rig,
                Progress* progress) {
  return by_rig ? Try(in, cameras, kHoldRig, progress) : TryWithoutRig(in, cameras, progress);
}

}  // namespace keypose::fit
