// When each frame of the animation is shown, and whether the next one follows by a glide or a step.
#pragma once

#include <string>
#include <vector>

#include "core/mesh.h"

namespace keypose::exporting {

struct PlaybackOptions {
  double fps = 24;            ///< frames a second
  int hold = 0;               ///< extra frames that the first and the last frame stay
  std::string loop = "none";  ///< "none", or "pingpong": forwards, then back to the first frame
};

/// What the frames are to a player.
struct Clip {
  std::vector<int> picture;  ///< of each frame: the first frame with the same positions
  std::vector<char> stands;  ///< of each frame: 1: its picture stands until the next frame comes;
                             ///< 0: players blend
  bool loop = false;         ///< the last frame is the first one again
  int frame_count() const { return static_cast<int>(picture.size()); }
};

/// @param stands  of each frame, as `interpolate` plans it; empty when that is not known: then
/// pictures that show for two frames or more
///                stand to their end
/// Same positions means the same bits.
Clip MakeClip(const std::vector<PointsX3>& points, std::vector<char> stands, bool loop);

/// One moment of the animation at which exactly one frame shows.
struct Moment {
  double seconds = 0;
  int frame = 0;
  bool stands = false;  ///< until the next moment, which then comes as a step; else the two blend
};

/// Moments in order of time, from 0 s. Held frames have two moments: their begin and end. A last
/// picture that comes as a step stands for a frame, unless the animation goes round.
std::vector<Moment> PlaybackMoments(const Clip& clip, const PlaybackOptions& options);

/// A frame at a time, for a sampler.
struct Keyframe {
  double seconds = 0;
  int frame = 0;
};
/// The same as keyframes between which all is linear: what stands gets a second one a thousandth of
/// a frame before the step (more where single precision cannot tell the two apart). Times rise
/// strictly, also in single precision.
std::vector<Keyframe> LinearKeyframes(const std::vector<Moment>& moments, const Clip& clip,
                                      double fps);

/// The keyframes at which a picture changes, and the last, when every change is a step: nothing
/// lies between pictures then. Empty where one blends into another.
std::vector<Keyframe> StepKeyframes(const std::vector<Moment>& moments, const Clip& clip);

}  // namespace keypose::exporting
