// From a timeline to frames: the span and the share of its way for each frame, and frames that
// repeat an earlier one.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "core/values/timeline.h"

namespace keypose::interpolation {

/// The way from key k to key k + 1.
struct Span {
  int frames = 1;  ///< from leaving the first key to reaching the second; 0 when the first key is
                   ///< held until the second
  int hold = 0;    ///< frames of hold at the first key, before these
  Travel travel = Travel::kSmooth;
  Ease ease;
  std::map<std::string, TimelineTurn> turns;  ///< by region
};

struct PlannedFrame {
  int span = 0;      ///< 0 .. keys - 2
  double way = 0;    ///< share of the span's way, after easing; 0 at its first key, 1 at its second
  int key = -1;      ///< the key whose bits the frame has, or -1
  int same_as = -1;  ///< an earlier frame with the same bits, or -1
  double time_s = 0;    ///< on the timeline's clock
  bool stands = false;  ///< the picture stays until the next frame (steps, 'on twos'); else motion
                        ///< continues between the two
};

struct Schedule {
  double fps = 24, start_s = 0;
  bool loop = false, overshoot = false;
  int end_hold = 0;         ///< frames of hold at the last key, after its first frame
  std::vector<Span> spans;  ///< keys - 1
  std::vector<PlannedFrame> frames;
  std::vector<int> key_frames;  ///< where each key begins
};

/// Key times and holds are rounded to frames, so that every key is shown with its own bits. Steps
/// ('on twos') count from the span's first key.
///
/// @param key_count  as many as the timeline's
/// @param steps      in-betweens of each span when the timeline has no times
/// @throws InputError  another number of keys, keys less than a frame apart (named), more than a
/// million frames
Schedule MakeSchedule(const Timeline& timeline, int key_count, int steps, const std::string& name);

/// Without a timeline: `in_betweens` has one number per span; smooth, 24 frames per second.
Schedule MakeSchedule(const std::vector<int>& in_betweens);

}  // namespace keypose::interpolation
