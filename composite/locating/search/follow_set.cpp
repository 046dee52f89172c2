#include "composite/locating/search/follow_set.h"

#include <algorithm>
#include <cmath>

#include "composite/locating/set/set_cameras.h"
#include "core/values/size_of.h"
#include "core/values/tuned.h"

namespace keypose::composite {
namespace {

struct SetTuning {
  // Of the weights of the mesh's equations beside the set's, where nothing else tells; chosen on
  // the film of seed 1 with a camera that swings and draws nearer.
  KEYPOSE_TUNED(double, kTrustInMesh, 0.2);
};

constexpr int kLeastSeen = 20;  // places of the set that tell a picture's camera
constexpr int kLooks = 2;       // at the character, as the lens that the set shows changes it

/// A picture of a moving camera: a frame, a plate, or both.
struct Passing {
  double time = 0;
  int frame = -1;
  const Image8* plate = nullptr;
};

/// Frames, and the plates between the first and the last one, in the order of time.
std::vector<Passing> PassingPictures(const ShotInput& input) {
  std::vector<Passing> pictures;
  for (int i = 0; i < SizeOf(input.frames); ++i) pictures.push_back({input.frames[i].time, i});
  for (const TimedPlate& plate : input.plates) {
    const auto at = std::find_if(pictures.begin(), pictures.end(),
                                 [&](const Passing& p) { return p.time == plate.time; });
    if (at != pictures.end())
      at->plate = &plate.picture;
    else if (plate.time > input.frames[0].time && plate.time < input.frames.back().time)
      pictures.push_back({plate.time, -1, &plate.picture});
  }
  std::sort(pictures.begin(), pictures.end(),
            [](const Passing& a, const Passing& b) { return a.time < b.time; });
  return pictures;
}

std::vector<SetTrack> TracksOf(const std::vector<Passing>& pictures, ShotFrames& frames,
                               Progress* progress) {
  std::vector<SetPicture> set;
  for (const Passing& p : pictures) {
    if (p.plate) {
      set.push_back({p.plate, nullptr});
      continue;
    }
    const LocateFrame& frame = frames[p.frame].frame;
    set.push_back({&frame.picture, &frame.matte});
  }
  SubProgress tracking(progress, 0.88, 0.92);
  return FindSetTracks(set, &tracking);
}

NormalEquations CharacterIn(ShotFrames& frames, int i) {
  return EquationsOf(frames.FigureOf(i).fine, frames[i].evidence.back(), frames[i].at,
                     {kFine, frames.texture(), true});
}

/// What all frames say of the focal length is as sure as its profile, in which what the mesh
/// cannot explain counts as noise.
void WeighFocal(ShotFrames& frames, double focal_deviation, SetCameraInput& set) {
  set.character_weight = SetTuning::kTrustInMesh;
  if (!set.focal_free) return;
  for (int i = 1; i < frames.count(); ++i) {
    const LensPart part = Eliminated(CharacterIn(frames, i));
    set.focal_information += part.h(0, 0);
    set.focal_gradient += part.g[0];
  }
  const double all = Eliminated(set.character).h(0, 0) + set.focal_information;
  set.character_weight = std::min(1.0, 1 / (std::pow(focal_deviation, 2) * all));
  set.focal_information *= set.character_weight;
  set.focal_gradient *= set.character_weight;
  const ShotInput& input = frames.input();
  if (const double prior = input.focal_deviation; prior > 0) {
    set.focal_information += 1 / (prior * prior);
    set.focal_gradient += std::log(input.camera.fx / set.first.camera.fx) / (prior * prior);
  }
}

SetCameraInput SetInput(ShotFrames& frames, const std::vector<SetTrack>& tracks, int pictures,
                        double focal_deviation) {
  const Figure& figure = frames.FigureOf(0).fine;
  SetCameraInput set;
  set.pictures = pictures;
  set.tracks = tracks;
  set.first = frames[0].at;
  set.table_height = figure.points.col(2).minCoeff();
  set.character = CharacterIn(frames, 0);
  set.center = figure.center;
  set.radius = figure.radius;
  set.focal_free = !frames.input().focal_fixed;
  WeighFocal(frames, focal_deviation, set);
  return set;
}

bool IsSeenByAllFrames(const std::vector<Passing>& pictures, const SetCameras& set) {
  if (set.focal_deviation > kMostUncertain) return false;
  for (int p = 0; p < SizeOf(pictures); ++p)
    if (pictures[p].frame >= 0 && set.seen[p] < kLeastSeen) return false;
  return true;
}

SetFinding TakeCameras(ShotFrames& frames, const std::vector<Passing>& pictures,
                       const SetCameras& found) {
  SetFinding set{found.places, found.on_table, found.rms_px, found.focal_deviation, {}};
  for (int p = 0; p < SizeOf(pictures); ++p) {
    const Rigid3& camera = found.cameras[p].camera_from_mesh;
    if (const int i = pictures[p].frame; i >= 0)
      frames[i].camera_from_world = camera;
    else if (found.seen[p] >= kLeastSeen)
      set.between.push_back({pictures[p].time, camera});
  }
  return set;
}

}  // namespace

std::optional<SetFinding> FollowSet(ShotFrames& frames, double focal_deviation,
                                    Progress* progress) {
  if (frames.input().still || frames.count() < 2) return std::nullopt;
  const std::vector<Passing> pictures = PassingPictures(frames.input());
  const std::vector<SetTrack> tracks = TracksOf(pictures, frames, progress);
  std::optional<SetCameras> found;
  for (int look = 0; look < kLooks; ++look) {
    frames.Tell(0.9 + 0.05 * look / kLooks, "the camera by the set");
    const auto now = SolveSetCameras(SetInput(frames, tracks, SizeOf(pictures), focal_deviation));
    if (!now || !IsSeenByAllFrames(pictures, *now)) break;
    found = now;
    for (int i = 0; i < frames.count(); ++i) {
      frames.SetLens(i, found->cameras[0].camera);
      frames.RefinePlace(i);
    }
  }
  if (!found) return std::nullopt;
  return TakeCameras(frames, pictures, *found);
}

}  // namespace keypose::composite
