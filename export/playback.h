// When each frame of the animation is shown.
#pragma once

#include <string>
#include <vector>

namespace keypose::exporting {

struct PlaybackOptions {
  double fps = 24;            ///< frames a second
  int hold = 0;               ///< extra frames that the first and the last frame stay
  std::string loop = "none";  ///< "none", or "pingpong": forwards, then back to the first frame
};

/// One moment of the animation at which exactly one frame shows; between moments the two frames blend.
struct Moment {
  double seconds = 0;
  int frame = 0;
};

/// Moments in order of time, from 0 s. Held frames have two moments: their begin and end.
std::vector<Moment> PlaybackMoments(int frame_count, const PlaybackOptions& options);

}  // namespace keypose::exporting
