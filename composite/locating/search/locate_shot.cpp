#include "composite/locating/search/locate_shot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <numbers>

#include "composite/locating/mattes/mattes.h"
#include "composite/locating/set/set_cameras.h"
#include "core/errors.h"
#include "core/size_of.h"
#include "core/tuned.h"

namespace keypose::composite {
namespace {

// Chosen on the clay creature's seeds 1 to 4 (synth).
struct ShotTuning {
  KEYPOSE_TUNED(double, kFollowed, 1.5);     // px at 480: the place before still serves
  KEYPOSE_TUNED(double, kColourMatte, 1.5);  // px, deviation of mattes made by colours
  KEYPOSE_TUNED(double, kOnePlace, 0.1);     // px that one place for all frames may cost
  // px at 960: deviation of what a matte lies beside the figure all round; of the skull's and the
  // plush dog's photographs it is 0.3 and 0.7.
  KEYPOSE_TUNED(double, kMatteOffset, 0.5);
  // Of the weights of the mesh's equations beside the set's, where nothing else tells; chosen on
  // the film of seed 1 with a camera that swings and draws nearer.
  KEYPOSE_TUNED(double, kTrustInMesh, 0.2);
};

constexpr double kMostUncertain = 0.1;     // of the focal length
constexpr double kRollFree = 1e-4;         // ratio of eigenvalues
constexpr double kReach = 6, kFine = 2.5;  // px
constexpr int kLensFrames = 8, kClicksForFocal = 6;
constexpr int kLeastSeen = 20;       // places of the set that tell a picture's camera
constexpr int kLooks = 2;            // at the character, as the lens that the set shows changes it
constexpr double kQuickReach = 20;   // px, of the smallest size
constexpr double kWithin = 0.006;    // of the longer side: how well features place outlines
constexpr double kFarWithin = 0.03;  // likewise, the frame before

class Locator {
 public:
  Locator(const ShotInput& input, Progress* progress) : input_(input), progress_(progress) {
    scales_ = SearchScales(input.camera.width, input.camera.height);
    if (!input.texture || input.quick) return;
    texture_ = std::make_unique<GreyTexture>(*input.mesh, *input.texture);
    Mesh first = *input.mesh;
    first.points = input.poses[input.frames[0].pose];
    SurfaceFeatureOptions options;
    options.directions = 28, options.size = 480, options.most = 900;
    SubProgress rendering(progress, 0, 0.2);
    features_ = std::make_unique<SurfaceFeatures>(first, *input.texture, options, &rendering);
  }

  LocatedShot Locate() {
    if (input_.quick) return LocateQuickly();
    for (int i = 0; i < count(); ++i) FindFrame(i);
    MakeEvidences();
    SolveLens();
    for (int i = 0; i < count(); ++i) FinishFrame(i);
    JoinPlaces();
    FollowSet();
    return Result();
  }

 private:
  struct State {
    LocateFrame frame;  // with a matte made by colours, if there was none
    FoundPlace found;
    Placement at;
    std::vector<Evidence> evidence;  // one for each of scales_
    std::optional<Rigid3> camera_from_world;
  };
  /// A picture of a moving camera: a frame, a plate, or both.
  struct Passing {
    double time = 0;
    int frame = -1;
    const Image8* plate = nullptr;
  };

  int count() const { return SizeOf(input_.frames); }
  bool focal_known() const { return input_.focal_fixed || input_.focal_deviation > 0; }
  Look look() const { return {texture_.get(), features_.get()}; }
  void Tell(double fraction, const std::string& what) {
    ReportProgress(progress_, 0.2 + 0.8 * fraction, what);
  }

  const PosedFigure& FigureOf(int i) {
    std::unique_ptr<PosedFigure>& figure = figures_[input_.frames[i].pose];
    if (!figure)
      figure =
          std::make_unique<PosedFigure>(input_.poses[input_.frames[i].pose], input_.mesh->faces);
    return *figure;
  }

  /// Whether the frame shows the figure about where the frame before did.
  bool Follow(State& state, const PosedFigure& figure) {
    if (states_.empty() || state.frame.matte.empty() || !state.frame.clicks.empty()) return false;
    const State& before = states_.back();
    const Evidence rough = MakeEvidence(state.frame.picture, state.frame.matte,
                                        state.frame.matte_deviation_px, scales_[0]);
    state.at = Refined(figure.fine, rough, before.at, {20, 3, 8, texture_.get()}, {});
    const double off = MatchOutlines(FindSilhouette(figure.fine, state.at.Scaled(rough.scale), 2),
                                     rough.outline, 12)
                           .Mean(12);
    if (off > ShotTuning::kFollowed) return false;
    state.found = {state.at, before.found.method, {}, 0};
    return true;
  }

  void FindFrame(int i) {
    Tell(0.6 * i / count(), "finding the character in " + input_.frames[i].name);
    State state;
    state.frame = input_.frames[i];
    const PosedFigure& figure = FigureOf(i);
    if (state.frame.matte.empty() && state.frame.clicks.empty() && !features_ && !states_.empty())
      ColourMatte(state, figure, states_.back().at, kFarWithin);
    const bool followed = Follow(state, figure);
    // A standing camera needs no more; a moving one could be followed into a wrong place.
    if (!followed || (features_ && !input_.still)) {
      const Camera& camera = states_.empty() ? input_.camera : states_[0].at.camera;
      const bool known = focal_known() || !states_.empty();
      const FoundPlace before = state.found;
      state.found =
          FindPlace(figure, state.frame, look(), camera, known, followed ? &before : nullptr);
      state.at = state.found.at;
    }
    if (state.frame.matte.empty()) MakeMatte(state, figure);
    states_.push_back(std::move(state));
  }

  /// Outlines by colours, near where features, clicks and grey values have them.
  void MakeMatte(State& state, const PosedFigure& figure) {
    Evidence bare = MakeEvidence(state.frame.picture, {}, 0, scales_.back());
    SetSightings(bare, state.found.sightings);
    SetClicks(bare, state.frame.clicks);
    state.at = Refined(figure.fine, bare, state.at, {kReach, kReach, 3, texture_.get()}, {});
    ColourMatte(state, figure, state.at, kWithin);
  }

  /// @param share  of the picture's longer side that the drawn mesh may be off
  void ColourMatte(State& state, const PosedFigure& figure, const Placement& at, double share) {
    const double side = std::max(input_.camera.width, input_.camera.height);
    const int within = std::max(4, static_cast<int>(share * side));
    state.frame.matte = MatteByColours(state.frame.picture, Covered(figure.fine, at), within);
    state.frame.matte_deviation_px = ShotTuning::kColourMatte;
  }

  void MakeEvidences() {
    for (State& state : states_)
      for (const double scale : scales_) {
        state.evidence.push_back(MakeEvidence(state.frame.picture, state.frame.matte,
                                              state.frame.matte_deviation_px, scale));
        SetSightings(state.evidence.back(), state.found.sightings);
        SetClicks(state.evidence.back(), state.frame.clicks);
      }
  }

  int FramesApart() const { return (count() + kLensFrames - 1) / kLensFrames; }
  /// Some frames, evenly chosen, at one size.
  std::vector<SharedFrame> LensFrames(int level) {
    std::vector<SharedFrame> frames;
    for (int i = 0; i < count(); i += FramesApart())
      frames.push_back({&FigureOf(i).fine, &states_[i].evidence[level], states_[i].at});
    return frames;
  }
  void TakeLens(const std::vector<SharedFrame>& frames) {
    const int step = FramesApart();
    for (int i = 0; i < count(); ++i) {
      const SharedFrame& near = frames[std::min(i / step, SizeOf(frames) - 1)];
      if (i % step == 0) states_[i].at = near.at;
      const Placement moved =
          WithFocal(states_[i].at, frames[0].at.camera.fx, FigureOf(i).fine.center);
      if (i % step != 0) states_[i].at = moved;
      states_[i].at.camera = frames[0].at.camera;
    }
  }

  RefineStep PlaceStep(double first_reach_px, int rounds) const {
    return {first_reach_px, kFine, rounds, texture_.get(), true};
  }
  /// The matte's offset serves the lens alone. It is that of all outlines together, so that a
  /// single frame is placed better without it (0.14 instead of 0.21 % of the distance on the
  /// skull's photographs, 0.43 instead of 0.63 on the plush dog's).
  RefineStep LensStep(double first_reach_px, int rounds) const {
    RefineStep step = PlaceStep(first_reach_px, rounds);
    step.matte_offset_px = matte_offset_px_;
    return step;
  }

  /// px of the whole picture.
  double OffsetDeviation() const {
    return ShotTuning::kMatteOffset / states_[0].evidence[MiddleLevel()].scale;
  }
  int MiddleLevel() const { return std::min(1, SizeOf(scales_) - 1); }

  LensPrior Prior() const {
    LensPrior prior;
    prior.focal_px = input_.camera.fx;
    prior.focal_deviation = input_.focal_deviation;
    prior.focal_free = !input_.focal_fixed && focal_ != "kept";
    prior.k1_free = input_.solve_k1 && focal_ != "kept";
    // Without its look, a figure that is nearer and one whose matte is wider are the same.
    if (texture_) prior.matte_offset_deviation = OffsetDeviation();
    return prior;
  }

  void SolveLens() {
    Tell(0.6, "lens");
    focal_ = input_.focal_fixed ? "given" : input_.focal_deviation > 0 ? "exif" : "solved";
    std::vector<SharedFrame> frames = LensFrames(MiddleLevel());
    matte_offset_px_ = RefineShared(frames, LensStep(kReach, 8), Prior());
    if (!input_.focal_fixed) {
      profile_ = ProfileFocal(frames, kReach, matte_offset_px_);
      AddOffsetDeviation(frames);
      if (focal_ == "solved" && profile_.deviation > kMostUncertain) {
        focal_ = "kept";
        for (SharedFrame& frame : frames) {
          frame.at = WithFocal(frame.at, input_.camera.fx, frame.figure->center);
          frame.at.camera.k1 = input_.camera.k1;
        }
        matte_offset_px_ = RefineShared(frames, LensStep(kReach, 8), Prior());
      }
    }
    TakeLens(frames);
    if (SizeOf(scales_) < 3 || focal_ == "kept") return;
    frames = LensFrames(SizeOf(scales_) - 1);
    matte_offset_px_ = RefineShared(frames, LensStep(kReach, 3), Prior());
    TakeLens(frames);
  }

  void AddOffsetDeviation(const std::vector<SharedFrame>& frames) {
    LensPrior prior = Prior();
    prior.focal_deviation = 0;
    prior.matte_offset_deviation = OffsetDeviation();
    const double more = FocalDeviationByOffset(frames, LensStep(kFine, 1), prior);
    profile_.deviation = std::min(1.0, std::hypot(profile_.deviation, more));
  }

  void FinishFrame(int i) {
    Tell(0.7 + 0.15 * i / count(), "refining " + input_.frames[i].name);
    if (i % FramesApart() != 0) RefineCoarsely(i);
    RefinePlace(i);
  }
  /// What the frames that the lens was solved from have been through already.
  void RefineCoarsely(int i) {
    State& state = states_[i];
    const Evidence& evidence = state.evidence[MiddleLevel()];
    state.at = Refined(FigureOf(i).fine, evidence, state.at, PlaceStep(kReach, 8), {});
  }
  void RefinePlace(int i) {
    State& state = states_[i];
    const Figure& figure = FigureOf(i).fine;
    state.at = Refined(figure, state.evidence.back(), state.at, PlaceStep(kReach, 4), {});
  }

  double ContourOf(int i, const Placement& at) {
    return MatchOutlines(FindSilhouette(FigureOf(i).fine, at, 2),
                         states_[i].evidence.back().outline, kReach)
        .Mean(kReach);
  }

  /// One place for all frames, where the meshes move as what was filmed does: then nothing jitters.
  void JoinPlaces() {
    if (!input_.still || count() < 2) return;
    std::vector<SharedFrame> frames;
    for (int i = 0; i < count(); ++i)
      frames.push_back({&FigureOf(i).fine, &states_[i].evidence.back(), states_[i].at});
    const Placement joined = RefinedStill(frames, states_[0].at, PlaceStep(kReach, 4), {});
    double worse = -1e300;
    for (int i = 0; i < count(); ++i)
      worse = std::max(worse, ContourOf(i, joined) - ContourOf(i, states_[i].at));
    one_place_ = worse <= ShotTuning::kOnePlace;
    if (one_place_)
      for (State& state : states_) state.at = joined;
  }

  /// Frames, and the plates between the first and the last one, in the order of time.
  std::vector<Passing> PassingPictures() const {
    std::vector<Passing> pictures;
    for (int i = 0; i < count(); ++i) pictures.push_back({input_.frames[i].time, i});
    for (const TimedPlate& plate : input_.plates) {
      const auto at = std::find_if(pictures.begin(), pictures.end(),
                                   [&](const Passing& p) { return p.time == plate.time; });
      if (at != pictures.end())
        at->plate = &plate.picture;
      else if (plate.time > input_.frames[0].time && plate.time < input_.frames.back().time)
        pictures.push_back({plate.time, -1, &plate.picture});
    }
    std::sort(pictures.begin(), pictures.end(),
              [](const Passing& a, const Passing& b) { return a.time < b.time; });
    return pictures;
  }

  std::vector<SetTrack> TracksOf(const std::vector<Passing>& pictures) {
    std::vector<SetPicture> set;
    for (const Passing& p : pictures)
      set.push_back(
          p.plate ? SetPicture{p.plate, nullptr}
                  : SetPicture{&states_[p.frame].frame.picture, &states_[p.frame].frame.matte});
    SubProgress progress(progress_, 0.88, 0.92);
    return FindSetTracks(set, &progress);
  }

  NormalEquations CharacterIn(int i) const {
    const Figure& figure = figures_.at(input_.frames[i].pose)->fine;
    return EquationsOf(figure, states_[i].evidence.back(), states_[i].at,
                       {kFine, texture_.get(), true});
  }

  SetCameraInput SetInput(const std::vector<SetTrack>& tracks, int pictures) const {
    const Figure& figure = figures_.at(input_.frames[0].pose)->fine;
    SetCameraInput set;
    set.pictures = pictures;
    set.tracks = tracks;
    set.first = states_[0].at;
    set.table_height = figure.points.col(2).minCoeff();
    set.character = CharacterIn(0);
    set.center = figure.center, set.radius = figure.radius;
    set.focal_free = !input_.focal_fixed;
    WeighFocal(set);
    return set;
  }

  /// What all frames say of the focal length is as sure as its profile, in which what the mesh
  /// cannot explain counts as noise.
  void WeighFocal(SetCameraInput& set) const {
    set.character_weight = ShotTuning::kTrustInMesh;
    if (!set.focal_free) return;
    for (int i = 1; i < count(); ++i) {
      const LensPart part = Eliminated(CharacterIn(i));
      set.focal_information += part.h(0, 0), set.focal_gradient += part.g[0];
    }
    const double all = Eliminated(set.character).h(0, 0) + set.focal_information;
    set.character_weight = std::min(1.0, 1 / (std::pow(profile_.deviation, 2) * all));
    set.focal_information *= set.character_weight, set.focal_gradient *= set.character_weight;
    if (const double prior = input_.focal_deviation; prior > 0) {
      set.focal_information += 1 / (prior * prior);
      set.focal_gradient += std::log(input_.camera.fx / set.first.camera.fx) / (prior * prior);
    }
  }

  /// The camera of a moving shot by what stands still behind the character, which may have been
  /// moved by hand meanwhile; world is the character's frame in the first picture.
  void FollowSet() {
    if (input_.still || count() < 2) return;
    const std::vector<Passing> pictures = PassingPictures();
    const std::vector<SetTrack> tracks = TracksOf(pictures);
    std::optional<SetCameras> found;
    for (int look = 0; look < kLooks; ++look) {
      Tell(0.9 + 0.05 * look / kLooks, "the camera by the set");
      const auto now = SolveSetCameras(SetInput(tracks, SizeOf(pictures)));
      if (!now || !IsSeenByAllFrames(pictures, *now)) break;
      found = now;
      TakeLens(found->cameras[0].camera);
    }
    if (!found) return;
    TakeSet(pictures, *found);
  }

  static bool IsSeenByAllFrames(const std::vector<Passing>& pictures, const SetCameras& set) {
    if (set.focal_deviation > kMostUncertain) return false;
    for (int p = 0; p < SizeOf(pictures); ++p)
      if (pictures[p].frame >= 0 && set.seen[p] < kLeastSeen) return false;
    return true;
  }

  /// A better lens: all places are refined for it.
  void TakeLens(const Camera& camera) {
    for (int i = 0; i < count(); ++i) {
      const Figure& figure = FigureOf(i).fine;
      states_[i].at = WithFocal(states_[i].at, camera.fx, figure.center);
      states_[i].at.camera = camera;
      RefinePlace(i);
    }
  }

  void TakeSet(const std::vector<Passing>& pictures, const SetCameras& found) {
    set_ = {found.places, found.on_table, found.rms_px, found.focal_deviation, {}};
    if (focal_ == "kept") focal_ = "solved";
    for (int p = 0; p < SizeOf(pictures); ++p) {
      if (const int i = pictures[p].frame; i >= 0)
        states_[i].camera_from_world = found.cameras[p].camera_from_mesh;
      else if (found.seen[p] >= kLeastSeen)
        set_->between.push_back({pictures[p].time, found.cameras[p].camera_from_mesh});
    }
  }

  void RequireTurnSeen(int i, double ratio) {
    const State& state = states_[i];
    if (ratio >= kRollFree || !state.found.sightings.empty() || !state.frame.clicks.empty() ||
        texture_)
      return;
    throw InputError(fmt::format(
        "locate: {}: the character looks the same from all sides about one axis, so its outline "
        "does not tell how it is turned; pass --clicks with one pair of pixel and place on the "
        "mesh "
        "beside that axis, or --textures",
        state.frame.name));
  }

  LocatedFrame Described(int i) {
    State& state = states_[i];
    const Figure& figure = FigureOf(i).fine;
    const Evidence& evidence = state.evidence.back();
    LocatedFrame frame;
    frame.at = state.at;
    frame.method = state.found.method;
    frame.inliers = SizeOf(state.found.sightings);
    frame.rival_ratio = state.found.rival_ratio;
    const OutlineMatches outlines =
        MatchOutlines(FindSilhouette(figure, state.at, 2), evidence.outline, 4 * kReach);
    frame.outlines = outlines.matches;
    frame.contour_px = ContourOf(i, state.at);
    frame.iou = Overlap(Covered(figure, state.at), state.frame.matte);
    if (texture_)
      frame.correlation =
          MatchGreys(figure, *texture_, evidence.luma, evidence.matte, state.at).correlation;
    frame.turn_ratio = SmoothOutlineEquations(figure, state.at).TurnEigenvalueRatio();
    RequireTurnSeen(i, frame.turn_ratio);
    frame.matte = state.frame.matte;
    frame.camera_from_world = state.camera_from_world;
    return frame;
  }

  LocatedShot LocateQuickly() {
    LocatedShot shot;
    for (int i = 0; i < count(); ++i) {
      Tell(static_cast<double>(i) / count(), "clicks of " + input_.frames[i].name);
      const bool known = focal_known() || i > 0;
      const Camera& camera = i > 0 ? shot.camera : input_.camera;
      shot.frames.push_back(ByClicks(i, camera, known));
      shot.camera = shot.frames[0].at.camera;
    }
    const bool solved = SizeOf(input_.frames[0].clicks) >= kClicksForFocal;
    shot.focal = input_.focal_fixed           ? "given"
                 : input_.focal_deviation > 0 ? "exif"
                 : solved                     ? "solved"
                                              : "kept";
    shot.focal_deviation = input_.focal_fixed ? 0 : focal_known() ? input_.focal_deviation : 1;
    return shot;
  }

  LocatedFrame ByClicks(int i, const Camera& camera, bool focal_is_known) {
    const LocateFrame& frame = input_.frames[i];
    const Figure& figure = FigureOf(i).fine;
    LocatedFrame found;
    found.method = "clicks";
    found.at = PlaceByClicks(camera, figure.points, frame.clicks, !focal_is_known);
    found.matte = frame.matte;
    if (frame.matte.empty()) {
      for (const SilhouettePoint& point : FindSilhouette(figure, found.at, 2))
        found.outlines.push_back({point.position, point.pixel, point.normal, 0, point.length_px});
      return found;
    }
    Evidence rough = MakeEvidence(frame.picture, frame.matte, frame.matte_deviation_px, scales_[0]);
    SetClicks(rough, frame.clicks);
    found.at = Refined(figure, rough, found.at, {kQuickReach, kFine, 4}, {});
    const Placement scaled = found.at.Scaled(rough.scale);
    const OutlineMatches outlines =
        MatchOutlines(FindSilhouette(figure, scaled, 2), rough.outline, 4 * kReach);
    found.outlines = outlines.matches;
    for (OutlineMatch& match : found.outlines)
      match.pixel /= rough.scale, match.distance_px /= rough.scale;
    found.contour_px = outlines.Mean(kReach) / rough.scale;
    found.iou = Overlap(Covered(figure, scaled), rough.matte);
    return found;
  }

  LocatedShot Result() {
    LocatedShot shot;
    for (int i = 0; i < count(); ++i) {
      Tell(0.95 + 0.05 * i / count(), "measuring");
      shot.frames.push_back(Described(i));
    }
    shot.camera = states_[0].at.camera;
    shot.focal = focal_;
    shot.matte_offset_px = matte_offset_px_;
    shot.profile_deviation = profile_.deviation;
    const double prior = input_.focal_deviation, own = profile_.deviation;
    if (focal_ == "exif")
      shot.focal_deviation = prior * own / std::hypot(prior, own);
    else if (focal_ != "given")
      shot.focal_deviation = own;
    if (set_ && focal_ != "given") shot.focal_deviation = set_->focal_deviation;
    shot.set = set_;
    shot.center_deviation_px =
        CenterDeviation(LensFrames(SizeOf(scales_) - 1), LensStep(kFine, 1), Prior());
    shot.one_place = one_place_;
    return shot;
  }

  const ShotInput& input_;
  Progress* progress_;
  std::vector<double> scales_;
  std::unique_ptr<GreyTexture> texture_;
  std::unique_ptr<SurfaceFeatures> features_;
  std::map<int, std::unique_ptr<PosedFigure>> figures_;
  std::vector<State> states_;
  std::string focal_;
  FocalProfile profile_{0, 1};
  double matte_offset_px_ = 0;  // of the whole picture
  bool one_place_ = false;
  std::optional<SetFinding> set_;
};

}  // namespace

LocatedShot LocateShot(const ShotInput& input, Progress* progress) {
  return Locator(input, progress).Locate();
}

}  // namespace keypose::composite
