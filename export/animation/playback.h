// When each frame of the animation is shown, and whether players blend or step to the next one.
#pragma once

#include <string>
#include <vector>

#include "core/values/mesh.h"
#include "core/values/size_of.h"

namespace keypose::exporting {

struct PlaybackOptions {
  double fps = 24;            ///< frames per second
  int hold = 0;               ///< extra frames for which the first and last frame are held
  std::string loop = "none";  ///< "none", or "pingpong": forwards, then back to the first frame
};

/// The frames as a player needs them.
struct Clip {
  std::vector<int> picture;  ///< per frame: the first frame with the same positions
  /// per frame: 1: its picture is held until the next frame; 0: players blend
  std::vector<char> stands;
  bool loop = false;  ///< the last frame equals the first
  int frame_count() const { return SizeOf(picture); }
};

/// @param stands  per frame, as planned by `interpolate`; empty if unknown: then pictures that
/// repeat for two frames or more are held to their end. Same positions means the same bits.
Clip MakeClip(const std::vector<PointsX3>& points, std::vector<char> stands, bool loop);

/// One moment of the animation at which exactly one frame is shown.
struct Moment {
  double seconds = 0;
  int frame = 0;
  bool stands = false;  ///< held until the next moment, which is then a step; else the two blend
};

/// Moments in order of time, from 0 s. Held frames have two moments: begin and end. If the last
/// picture follows a step, it is held for one frame, unless the animation loops.
std::vector<Moment> PlaybackMoments(const Clip& clip, const PlaybackOptions& options);

/// A frame and its time, for a sampler.
struct Keyframe {
  double seconds = 0;
  int frame = 0;
};
/// The moments as keyframes with linear interpolation. A held picture gets a second keyframe a
/// thousandth of a frame before the step (more if single precision cannot distinguish the two
/// times). Times strictly increase, also in single precision.
std::vector<Keyframe> LinearKeyframes(const std::vector<Moment>& moments, const Clip& clip,
                                      double fps);

/// If every change is a step: the keyframes at which the picture changes, and the last one. Empty
/// if any pictures blend.
std::vector<Keyframe> StepKeyframes(const std::vector<Moment>& moments, const Clip& clip);

/// Indices of the frames that a film at `fps` shows, one per picture; held frames repeat.
std::vector<int> FilmFrames(const std::vector<Moment>& moments, double fps);

}  // namespace keypose::exporting
