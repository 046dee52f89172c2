#include "fit/fit_pose.h"

#include <algorithm>

#include "core/values/size_of.h"
#include "fit/cameras/cameras_around.h"
#include "fit/cameras/late_cameras.h"

namespace keypose::fit {
namespace {

// How firmly a rig's cameras hold against the photographs: a table that is turned by hand stops a
// degree beside its mark.
constexpr double kHoldRig = 2;
// Outlines of one attempt agree clearly better from here on: share of the overlap with the masks.
constexpr double kClearly = 0.01;

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

/// How one attempt is made.
struct Way {
  const Mesh& mesh;              // near the figure
  const std::vector<View>& rig;  // where missing cameras are looked for; empty: anywhere
  double hold;                   // of the cameras
};

/// Where photographs have no camera: bends the template to nearly the pose by the others, and looks
/// again; once more for each that this finds, since it shows a further part.
/// @return how many it found; nothing if none was looked for
std::optional<int> PlaceLate(const FitInput& in, const Way& way, std::vector<FoundCamera>& cameras,
                             Progress* progress) {
  constexpr int kFewest = 2;
  if (in.texture.empty()) return {};
  BendOptions options;
  options.only_far = true;
  options.hold_cameras = way.hold;
  std::optional<int> late;
  double begin = 0;  // of this round, in the progress; nobody knows how many there will be
  for (int found = 1; found > 0; begin = (1 + begin) / 2) {
    const std::vector<BendView> placed = WithCameras(in.views, cameras);
    if (SizeOf(placed) == SizeOf(in.views) || SizeOf(placed) < kFewest) break;
    SubProgress round(progress, begin, (1 + begin) / 2), bending(&round, 0, 0.6),
        finding(&round, 0.6, 1);
    const BendPicks marks = MarksOf(in.picks, placed, in.unplaced, nullptr);
    const BendResult nearly =
        BendToViews(way.mesh, in.texture, in.stiffness, placed, marks, options, &bending);
    Mesh bent = way.mesh;
    bent.points = nearly.points;
    for (int v = 0, p = 0; v < SizeOf(in.views); ++v)
      if (cameras[v].found) cameras[v].camera_from_world = nearly.cameras[p++];
    found = FindLateCameras(bent, in.texture, in.views, way.rig, cameras, &finding);
    late = late.value_or(0) + found;
  }
  return late;
}

/// Without a result if fewer than two photographs are placed.
Attempt Try(const FitInput& in, const Way& way, std::vector<FoundCamera> cameras,
            Progress* progress) {
  Attempt attempt;
  SubProgress placing(progress, 0, 0.08), bending(progress, 0.08, 1);
  attempt.late = PlaceLate(in, way, cameras, &placing);
  attempt.placed = WithCameras(in.views, cameras);
  attempt.cameras = std::move(cameras);
  if (SizeOf(attempt.placed) < 2) return attempt;
  attempt.marks = MarksOf(in.picks, attempt.placed, in.unplaced, nullptr);
  BendOptions options;
  options.hold_cameras = way.hold;
  attempt.result = BendToViews(way.mesh, in.texture, in.stiffness, attempt.placed, attempt.marks,
                               options, &bending);
  return attempt;
}

Attempt TryOnRig(const FitInput& in, const Start& start, Progress* progress) {
  Mesh moved = in.mesh;
  for (Eigen::Index v = 0; v < moved.points.rows(); ++v)
    moved.points.row(v) =
        (start.on_rig->rig_from_template * in.mesh.points.row(v).transpose()).transpose();
  return Try(in, {moved, in.rig, kHoldRig}, start.cameras, progress);
}

Attempt TryWithoutRig(const FitInput& in, const std::vector<FoundCamera>& cameras,
                      Progress* progress) {
  const std::vector<View> none;
  std::vector<FoundCamera> sure = cameras;
  const bool doubtful = KeepSureCameras(sure);
  SubProgress first(progress, 0, doubtful ? 0.5 : 1), second(progress, 0.5, 1);
  Attempt all = Try(in, {in.mesh, none, 0}, cameras, &first);
  if (!doubtful) return all;
  Attempt held = Try(in, {in.mesh, none, kHoldRig}, sure, &second);
  held.doubtful_dropped = held.Overlap() > all.Overlap() + kClearly;
  all.doubtful_dropped = false;
  return *held.doubtful_dropped ? std::move(held) : std::move(all);
}

}  // namespace

double Attempt::Overlap() const {
  double sum = 0;
  for (const ViewQuality& view : result.view_quality) sum += view.overlap;
  return sum / std::max(1, SizeOf(result.view_quality));
}

double Attempt::Agreement() const {
  constexpr double kUnplaced = 0.85, kNone = -1;
  const int all = SizeOf(cameras), of_these = SizeOf(placed);
  if (result.points.rows() == 0) return kNone;
  return (of_these * Overlap() + (all - of_these) * kUnplaced) / std::max(1, all);
}

Eigen::Vector2d PreparedPixel(const PreparedView& view, const Scene& scene,
                              const Eigen::Vector2d& pixel) {
  return view.camera().Project(scene.views[view.scene_index].camera.Unproject(pixel));
}

BendPicks MarksOf(const PosePicks& picks, const std::vector<BendView>& views, const Scene& scene,
                  std::vector<std::string>* lost) {
  BendPicks marks;
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

std::vector<Start> StartsOf(const std::vector<RigMotion>& motions, const std::vector<View>& rig,
                            const std::vector<FoundCamera>& cameras) {
  const bool clear = !motions.empty() && motions.front().clear;
  std::vector<Start> starts;
  for (int m = clear ? 0 : 1; m < SizeOf(motions); ++m)
    starts.push_back({CamerasUnder(motions[m], rig, cameras), motions[m]});
  if (!clear) starts.push_back({cameras, {}});
  return starts;
}

std::vector<Start> StartsAround(const FitInput& in, const std::vector<FoundCamera>& around,
                                const std::vector<Start>& tried) {
  const auto is_new = [&](const Start& start) {
    return !start.on_rig || std::none_of(tried.begin(), tried.end(), [&](const Start& other) {
      return other.on_rig && other.on_rig->rig_view == start.on_rig->rig_view;
    });
  };
  std::vector<Start> starts;
  for (Start& start : StartsOf(FindRigMotions(in.mesh, around, in.views, in.rig), in.rig, around))
    if (is_new(start)) starts.push_back(std::move(start));
  return starts;
}

Attempt FitPose(const FitInput& in, const std::vector<Start>& starts, Progress* progress,
                std::optional<Attempt> before) {
  // On the rig the figure also stands right, so cameras found one by one must do better.
  const auto agreement = [](const Attempt& attempt) {
    return attempt.Agreement() - (attempt.on_rig ? 0 : kClearly);
  };
  std::optional<Attempt> best = std::move(before);
  for (int s = 0; s < SizeOf(starts); ++s) {
    SubProgress part(progress, 1.0 * s / SizeOf(starts), (s + 1.0) / SizeOf(starts));
    const Start& start = starts[s];
    Attempt attempt =
        start.on_rig ? TryOnRig(in, start, &part) : TryWithoutRig(in, start.cameras, &part);
    attempt.on_rig = start.on_rig;
    if (!best || agreement(attempt) > agreement(*best)) best = std::move(attempt);
  }
  return best ? *std::move(best) : Attempt();
}

Attempt FitAgain(const FitInput& in, Attempt attempt, Progress* progress) {
  constexpr int kMostRounds = 2;
  for (int round = 0; round < kMostRounds; ++round) {
    if (attempt.on_rig || attempt.result.points.rows() == 0) break;
    SubProgress part(progress, 1.0 * round / kMostRounds, (round + 1.0) / kMostRounds);
    SubProgress looking(&part, 0, 0.2), bending(&part, 0.2, 1);
    Mesh bent = in.mesh;
    bent.points = attempt.result.points;
    const auto cameras = FindCamerasAround(bent, in.texture, in.views, attempt.cameras, &looking);
    Attempt again = TryWithoutRig(in, cameras, &bending);
    const double gained = again.Agreement() - attempt.Agreement();
    if (gained > 0) attempt = std::move(again);
    if (gained < kClearly) break;
  }
  return attempt;
}

}  // namespace keypose::fit
