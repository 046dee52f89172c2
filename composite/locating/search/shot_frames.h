// The frames of a shot while its camera is looked for: their evidence, and where each has the
// figure.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "composite/locating/search/located_shot.h"
#include "core/values/progress.h"

namespace keypose::composite {

struct FrameState {
  LocateFrame frame;  ///< with a matte made by colours, if there was none
  FoundPlace found;
  Placement at;
  std::vector<PictureEvidence> evidence;  ///< one for each size of the picture, coarse to fine
  std::optional<Rigid3> camera_from_world;
};

/// How outlines are compared: at first, and where they are near [px].
inline constexpr double kReach = 6, kFine = 2.5;
/// Beyond this a solved focal length is not believed: deviation of its logarithm.
inline constexpr double kMostUncertain = 0.1;

class ShotFrames {
 public:
  /// @param input  must outlive this
  ShotFrames(const ShotInput& input, Progress* progress);

  const ShotInput& input() const { return input_; }
  int count() const { return static_cast<int>(input_.frames.size()); }
  /// A frame that Find has been called for.
  FrameState& operator[](int i) { return states_[i]; }
  const PosedFigure& FigureOf(int i);
  /// Null: the character's look is unknown.
  const GreyTexture* texture() const { return texture_.get(); }
  bool focal_known() const { return input_.focal_fixed || input_.focal_deviation > 0; }

  /// Finds the figure in frame i, and makes a matte by colours where there is none. Frames before
  /// it must have been found.
  /// @throws InputError  see FindPlace
  void Find(int i);
  void MakeEvidences();
  /// Sizes of the picture, as indices of FrameState::evidence.
  int middle() const { return std::min(1, finest()); }
  int finest() const { return static_cast<int>(scales_.size()) - 1; }
  double roughest_scale() const { return scales_[0]; }

  RefineStep PlaceStep(double first_reach_px, int rounds) const;
  /// What the frames that the lens was solved from have been through already.
  void RefineCoarsely(int i);
  void RefinePlace(int i);
  /// Another lens: the place keeps its size in the picture.
  void SetLens(int i, const Camera& camera);
  /// Mean distance of the outlines in the whole picture [px].
  double ContourOf(int i, const Placement& at);
  void Tell(double fraction, const std::string& what) const;

 private:
  bool Follow(FrameState& state, const PosedFigure& figure);
  void MakeMatte(FrameState& state, const PosedFigure& figure);
  void ColourMatte(FrameState& state, const PosedFigure& figure, const Placement& at, double share);

  const ShotInput& input_;
  Progress* progress_;
  std::vector<double> scales_;
  std::unique_ptr<GreyTexture> texture_;
  std::unique_ptr<SurfaceFeatures> features_;
  std::map<int, std::unique_ptr<PosedFigure>> figures_;  ///< by pose
  std::vector<FrameState> states_;
};

}  // namespace keypose::composite
