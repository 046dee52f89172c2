#include "composite/locating/search/shot_frames.h"

#include <algorithm>

#include "composite/locating/mattes/mattes.h"
#include "core/values/tuned.h"

namespace keypose::composite {
namespace {

// Chosen on the clay creature's seeds 1 to 4 (synth).
struct FrameTuning {
  KEYPOSE_TUNED(double, kFollowed, 1.5);     // px at 480: the place before still serves
  KEYPOSE_TUNED(double, kColourMatte, 1.5);  // px, deviation of mattes made by colours
};

constexpr double kWithin = 0.006;    // of the longer side: how well features place outlines
constexpr double kFarWithin = 0.03;  // likewise, the frame before

}  // namespace

ShotFrames::ShotFrames(const ShotInput& input, Progress* progress)
    : input_(input), progress_(progress) {
  scales_ = SearchScales(input.camera.width, input.camera.height);
  if (!input.texture || input.quick) return;
  texture_ = std::make_unique<GreyTexture>(*input.mesh, *input.texture);
  Mesh first = *input.mesh;
  first.points = input.poses[input.frames[0].pose];
  SurfaceFeatureOptions options;
  options.directions = 28;
  options.size = 480;
  options.most = 900;
  SubProgress rendering(progress, 0, 0.2);
  features_ = std::make_unique<SurfaceFeatures>(first, *input.texture, options, &rendering);
}

void ShotFrames::Tell(double fraction, const std::string& what) const {
  ReportProgress(progress_, 0.2 + 0.8 * fraction, what);
}

const PosedFigure& ShotFrames::FigureOf(int i) {
  std::unique_ptr<PosedFigure>& figure = figures_[input_.frames[i].pose];
  if (!figure)
    figure = std::make_unique<PosedFigure>(input_.poses[input_.frames[i].pose], input_.mesh->faces);
  return *figure;
}

/// Whether the frame shows the figure about where the frame before did.
bool ShotFrames::Follow(FrameState& state, const PosedFigure& figure) {
  if (states_.empty() || state.frame.matte.empty() || !state.frame.clicks.empty()) return false;
  const FrameState& before = states_.back();
  const PictureEvidence rough = MakeEvidence(state.frame.picture, state.frame.matte,
                                             state.frame.matte_deviation_px, scales_[0]);
  state.at = Refined(figure.fine, rough, before.at, {20, 3, 8, texture_.get()}, {});
  const double off =
      MatchOutlines(FindSilhouette(figure.fine, state.at.Scaled(rough.scale), 2), rough.outline, 12)
          .Mean(12);
  if (off > FrameTuning::kFollowed) return false;
  state.found = {state.at, before.found.method, {}, 0};
  return true;
}

void ShotFrames::Find(int i) {
  FrameState state;
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
    state.found = FindPlace(figure, state.frame, {texture_.get(), features_.get()}, camera, known,
                            followed ? &before : nullptr);
    state.at = state.found.at;
  }
  if (state.frame.matte.empty()) MakeMatte(state, figure);
  states_.push_back(std::move(state));
}

/// Outlines by colours, near where features, clicks and grey values have them.
void ShotFrames::MakeMatte(FrameState& state, const PosedFigure& figure) {
  PictureEvidence bare = MakeEvidence(state.frame.picture, {}, 0, scales_.back());
  SetSightings(bare, state.found.sightings);
  SetClicks(bare, state.frame.clicks);
  state.at = Refined(figure.fine, bare, state.at, {kReach, kReach, 3, texture_.get()}, {});
  ColourMatte(state, figure, state.at, kWithin);
}

/// @param share  of the picture's longer side that the drawn mesh may be off
void ShotFrames::ColourMatte(FrameState& state, const PosedFigure& figure, const Placement& at,
                             double share) {
  const double side = std::max(input_.camera.width, input_.camera.height);
  const int within = std::max(4, static_cast<int>(share * side));
  state.frame.matte = MatteByColours(state.frame.picture, Covered(figure.fine, at), within);
  state.frame.matte_deviation_px = FrameTuning::kColourMatte;
}

void ShotFrames::MakeEvidences() {
  for (FrameState& state : states_)
    for (const double scale : scales_) {
      state.evidence.push_back(MakeEvidence(state.frame.picture, state.frame.matte,
                                            state.frame.matte_deviation_px, scale));
      SetSightings(state.evidence.back(), state.found.sightings);
      SetClicks(state.evidence.back(), state.frame.clicks);
    }
}

RefineStep ShotFrames::PlaceStep(double first_reach_px, int rounds) const {
  return {first_reach_px, kFine, rounds, texture_.get(), true};
}

void ShotFrames::RefineCoarsely(int i) {
  FrameState& state = states_[i];
  const PictureEvidence& evidence = state.evidence[middle()];
  state.at = Refined(FigureOf(i).fine, evidence, state.at, PlaceStep(kReach, 8), {});
}

void ShotFrames::RefinePlace(int i) {
  FrameState& state = states_[i];
  const Figure& figure = FigureOf(i).fine;
  state.at = Refined(figure, state.evidence.back(), state.at, PlaceStep(kReach, 4), {});
}

void ShotFrames::SetLens(int i, const Camera& camera) {
  FrameState& state = states_[i];
  state.at = WithFocal(state.at, camera.fx, FigureOf(i).fine.center);
  state.at.camera = camera;
}

double ShotFrames::ContourOf(int i, const Placement& at) {
  return MatchOutlines(FindSilhouette(FigureOf(i).fine, at, 2), states_[i].evidence.back().outline,
                       kReach)
      .Mean(kReach);
}

}  // namespace keypose::composite
